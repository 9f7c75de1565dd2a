#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::bench {

/// Another program of the machine, found along PATH. It ends with this object.
class ChildProgram {
 public:
  /// Starts it; its stdout comes here, its stderr is ours. Null: there is no such program. Throws std::runtime_error
  /// when there is but it cannot be started.
  [[nodiscard]] static std::unique_ptr<ChildProgram> start(std::vector<std::string> words);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// It has ended by itself.
  [[nodiscard]] bool has_ended() noexcept;
  /// Waits for its end; what it has printed. Throws std::runtime_error when it failed.
  [[nodiscard]] std::string finish();

 private:
  ChildProgram(pid_t process, port::FileDescriptor out, std::string name);
  int wait() noexcept;

  pid_t process_;  ///< -1: it has ended
  port::FileDescriptor out_;
  std::string name_;
};

}  // namespace driveline::bench
