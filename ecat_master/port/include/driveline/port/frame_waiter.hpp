#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <tl/expected.hpp>

#include "driveline/port/port_error.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

/// Waits for frames at one or two ports. Faster than RawSocketPort::wait_readable(), for a simulated line that must
/// answer each frame at once: the timer of the deadline is armed before the wait and keeps running when a frame
/// arrives, instead of being cancelled first, which costs some microseconds on a virtual machine.
class FrameWaiter {
 public:
  /// `second` may be null. Both ports must outlive the waiter.
  [[nodiscard]] static tl::expected<std::unique_ptr<FrameWaiter>, PortError> open(const RawSocketPort& first,
                                                                                  const RawSocketPort* second);

  /// Waits until a frame can be received or until `deadline` on the monotonic clock. Returns true when a frame can be
  /// received.
  bool wait(std::chrono::nanoseconds deadline) noexcept;

 private:
  FrameWaiter(rt::FileDescriptor timer, std::array<int, 2> sockets) noexcept
      : timer_(std::move(timer)), sockets_(sockets) {}

  rt::FileDescriptor timer_;
  std::array<int, 2> sockets_;
  std::chrono::nanoseconds armed_{-1};
};

}  // namespace driveline::port
