#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace driveline::bench {

/// Another program, which ends with this object.
class ChildProcess {
 public:
  /// Starts command[0], a path, with the rest as its arguments. Its stdout and stderr are kept. Throws
  /// std::runtime_error when it cannot be started.
  explicit ChildProcess(std::vector<std::string> command);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  [[nodiscard]] pid_t id() const noexcept { return id_; }
  void signal(int number) const noexcept;
  /// Whether it has ended; does not wait.
  [[nodiscard]] bool ended();
  /// Waits for its end and returns its stdout. Throws std::runtime_error with the last line of its stderr when it
  /// failed.
  [[nodiscard]] std::string finish();

 private:
  void wait(int options);

  std::string program_;
  pid_t id_ = 0;
  int output_ = -1;
  int errors_ = -1;
  std::optional<int> status_;
};

/// What a process has used so far.
struct ProcessUse {
  double cpu_s = 0.0;     ///< of all its threads
  double peak_mib = 0.0;  ///< most memory that was resident
};

/// Nothing: there is no such process.
[[nodiscard]] std::optional<ProcessUse> use_of(pid_t process);

/// A child of `parent` whose name begins so; 0: there is none. Linux keeps 15 bytes of a name.
[[nodiscard]] pid_t child_named(pid_t parent, const std::string& name);

}  // namespace driveline::bench
