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

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A program of ours in a process of its own, and the SOCK_SEQPACKET socket to it, which has number kSocket there. It
/// ends with this object.
///
/// Started by posix_spawn: a fork of a process whose memory is locked would make each of its pages fault once more.
class HelperProcess {
 public:
  /// What became of a message.
  enum class Transfer : std::uint8_t { kDone, kNotNow, kEnded };
  /// Number of the socket in the new process.
  static constexpr int kSocket = 3;
  /// Until a process whose socket is closed is ended with force.
  static constexpr std::chrono::milliseconds kPatience{1000};

  /// None.
  HelperProcess() = default;
  HelperProcess(HelperProcess&& other) noexcept
      : socket_(std::move(other.socket_)), child_(std::exchange(other.child_, 0)) {}
  HelperProcess& operator=(HelperProcess&& other) noexcept;
  ~HelperProcess() { end(); }

  /// Starts `program` with `arguments` in a process group of its own. It has nothing of this process but stderr, also
  /// as its stdout, the socket, and `passed`, which have the numbers after kSocket there.
  [[nodiscard]] static Result<HelperProcess> start(const std::filesystem::path& program,
                                                   std::vector<std::string> arguments,
                                                   std::span<const int> passed = {});

  /// Without waiting.
  [[nodiscard]] Transfer send(std::span<const std::byte> message) noexcept;
  /// The same. kDone: `length` is that of the message, also of one that is longer than `room`.
  [[nodiscard]] Transfer receive(std::span<std::byte> room, std::size_t& length) noexcept;
  /// The process is to end: it reads the end of the socket.
  void finish() noexcept;
  /// Ends it with force, without waiting.
  void kill() noexcept;
  /// Its wait status (waitpid(2)) when it has ended by itself; there is none afterwards. Does not wait.
  std::optional<int> reap() noexcept;
  /// Closes the socket, which ends the process, and waits for it; its wait status, if there was one. With force after
  /// `patience`.
  std::optional<int> end(std::chrono::milliseconds patience = kPatience) noexcept;

  /// There is one.
  [[nodiscard]] bool valid() const noexcept { return child_ != 0; }
  /// 0: none.
  [[nodiscard]] pid_t id() const noexcept { return child_; }
  /// To wait for.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }

 private:
  HelperProcess(port::FileDescriptor socket, pid_t child) : socket_(std::move(socket)), child_(child) {}

  port::FileDescriptor socket_;
  pid_t child_ = 0;
};

/// "signal 6" or "status 1", of a wait status.
[[nodiscard]] std::string describe_end(int wait_status);

}  // namespace driveline::runtime
