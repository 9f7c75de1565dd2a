#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::bench {

/// Another program, searched in PATH unless its name is a path. The destructor ends it (SIGTERM).
class ChildProgram {
 public:
  /// Starts the program and stores its stdout and stderr. Null: there is no such program. Throws std::runtime_error if
  /// it exists but cannot be started.
  [[nodiscard]] static std::unique_ptr<ChildProgram> start(std::vector<std::string> words);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_; }
  void signal(int number) const noexcept;
  /// Whether the program has ended on its own; does not wait.
  [[nodiscard]] bool has_ended() noexcept;
  /// Waits for its end and returns its stdout. Throws std::runtime_error with the last line of its stderr if it failed.
  [[nodiscard]] std::string finish();

 private:
  ChildProgram(std::string name, rt::FileDescriptor output, rt::FileDescriptor errors);
  void wait(int options) noexcept;

  std::string name_;
  rt::FileDescriptor output_;
  rt::FileDescriptor errors_;
  pid_t process_ = -1;
  std::optional<int> status_;
};

/// Resources that a process has used so far.
struct ProcessUse {
  double cpu_s = 0.0;     ///< CPU time of all its threads
  double peak_mib = 0.0;  ///< peak resident memory
};

/// Nothing: there is no such process.
[[nodiscard]] std::optional<ProcessUse> use_of(pid_t process);

/// A child of `parent` whose name starts with `name`; 0: there is none. Linux stores 15 bytes of a name.
[[nodiscard]] pid_t child_named(pid_t parent, const std::string& name);

}  // namespace driveline::bench
