#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <string_view>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::canopen {

/// A connection that carries bytes both ways, a socket or a terminal, with a queue for what the other end does not take
/// at once. Only wait() waits.
class ByteStream {
 public:
  static constexpr std::size_t kInputBytes = 4096;   ///< read at a time
  static constexpr std::size_t kOutputBytes = 4096;  ///< that wait for the other end at most

  /// Takes over a descriptor, which no longer blocks. `clock` must outlive the stream.
  ByteStream(rt::FileDescriptor descriptor, rt::Clock& clock) noexcept;

  /// Returns bytes that have arrived, which are valid until the next call; empty: there are none now, or the stream has
  /// ended. \rtsafe
  [[nodiscard]] std::string_view read() noexcept;
  /// Sends a text, or queues what the other end does not take; false: there is no room, nothing was sent. \rtsafe
  [[nodiscard]] bool write(std::string_view text) noexcept;
  /// Waits until bytes can be read or the stream ends, or until `deadline` on the clock; what is queued is sent
  /// meanwhile. Returns false at the deadline. \rtsafe
  bool wait(std::chrono::nanoseconds deadline) noexcept;
  /// Whether nothing comes any more. \rtsafe
  [[nodiscard]] bool ended() const noexcept { return ended_; }
  /// Whether nothing can be sent any more. \rtsafe
  [[nodiscard]] bool broken() const noexcept { return broken_ || ended_; }
  /// Ends the stream from this side: what comes cannot be read. \rtsafe
  void end() noexcept { ended_ = true; }

 private:
  void flush() noexcept;
  void make_room() noexcept;

  rt::FileDescriptor descriptor_;
  rt::Clock& clock_;
  bool socket_;
  bool ended_ = false;
  bool broken_ = false;
  std::array<char, kInputBytes> input_{};
  std::array<char, kOutputBytes> output_{};
  std::size_t begin_ = 0;  ///< of what waits in output_
  std::size_t end_ = 0;
};

}  // namespace driveline::canopen
