#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A driveline program in its own process, and the SOCK_SEQPACKET socket to it, which has number kSocket there. The
/// process ends with this object.
///
/// Started by posix_spawn: after a fork of a process with locked memory, each of its pages would fault once more.
class HelperProcess {
 public:
  /// Result of the transfer of a message.
  enum class Transfer : std::uint8_t { kDone, kNotNow, kEnded };
  /// Number of the socket in the new process.
  static constexpr int kSocket = 3;
  /// Time after which a process whose socket is closed is killed.
  static constexpr std::chrono::milliseconds kEndTimeout{1000};

  /// Holds no process.
  HelperProcess() = default;
  HelperProcess(HelperProcess&& other) noexcept
      : socket_(std::move(other.socket_)), child_(std::exchange(other.child_, 0)) {}
  HelperProcess& operator=(HelperProcess&& other) noexcept;
  ~HelperProcess() { end(); }

  /// Starts `program` with `arguments` in its own process group. It inherits only stderr, used also as its stdout, the
  /// socket, and `passed`, whose descriptors get the numbers after kSocket. When memory runs out, the kernel ends it
  /// before this process.
  [[nodiscard]] static Result<HelperProcess> start(const std::filesystem::path& program,
                                                   std::vector<std::string> arguments,
                                                   std::span<const int> passed = {});

  /// Sends a message without waiting.
  [[nodiscard]] Transfer send(std::span<const std::byte> message) noexcept;
  /// Receives a message without waiting. kDone: `length` is that of the message, even if it is longer than `room`.
  [[nodiscard]] Transfer receive(std::span<std::byte> room, std::size_t& length) noexcept;
  /// Asks the process to end: it reads end-of-file from the socket.
  void finish() noexcept;
  /// Kills the process without waiting.
  void kill() noexcept;
  /// Returns its wait status (waitpid(2)) if it has ended; afterwards this object holds no process. Does not wait.
  std::optional<int> reap() noexcept;
  /// Closes the socket, which ends the process, and waits for its end; kills it after `timeout`. Returns its wait
  /// status, if there was a process.
  std::optional<int> end(std::chrono::milliseconds timeout = kEndTimeout) noexcept;

  /// Whether this object holds a process.
  [[nodiscard]] bool valid() const noexcept { return child_ != 0; }
  /// Returns the process number; 0: none.
  [[nodiscard]] pid_t id() const noexcept { return child_; }
  /// Returns the descriptor to wait for.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }

 private:
  HelperProcess(rt::FileDescriptor socket, pid_t child) : socket_(std::move(socket)), child_(child) {}

  rt::FileDescriptor socket_;
  pid_t child_ = 0;
};

/// Describes a wait status: "signal 6" or "status 1".
[[nodiscard]] std::string describe_end(int wait_status);

}  // namespace driveline::runtime
