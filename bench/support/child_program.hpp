#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::bench {

/// Another program, found along PATH unless its name is a path. It ends with this object (SIGTERM).
class ChildProgram {
 public:
  /// Starts it; its stdout and stderr are kept. Null: there is no such program. Throws std::runtime_error when there is
  /// but it cannot be started.
  [[nodiscard]] static std::unique_ptr<ChildProgram> start(std::vector<std::string> words);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_; }
  void signal(int number) const noexcept;
  /// It has ended by itself; does not wait.
  [[nodiscard]] bool has_ended() noexcept;
  /// Waits for its end; its stdout. Throws std::runtime_error with the last line of its stderr when it failed.
  [[nodiscard]] std::string finish();

 private:
  ChildProgram(std::string name, port::FileDescriptor output, port::FileDescriptor errors);
  void wait(int options) noexcept;

  std::string name_;
  port::FileDescriptor output_;
  port::FileDescriptor errors_;
  pid_t process_ = -1;
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
