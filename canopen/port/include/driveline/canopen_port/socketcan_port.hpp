#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_port/can_port_options.hpp"
#include "driveline/canopen_wire/socketcan.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::canopen {

/// A CAN interface of the kernel, or any descriptor that carries `struct can_frame` of linux/can.h, one in each
/// message.
///
/// Bit rate and mode are those of the interface (`ip link set can0 type can bitrate 500000`). The state of the bus
/// comes from its error frames, which are asked for also when the port does not report them. Frames of other programs
/// on this machine are received, those of the port itself are not. While the interface is down or the bus is off,
/// send() gives kDown; the port goes on when the interface does. Frames of CAN FD are skipped.
class SocketCanPort final : public CanPort {
 public:
  /// Opens an interface. Errors: the kernel has no CAN, there is no such interface, it is none of CAN, or down.
  [[nodiscard]] static tl::expected<std::unique_ptr<SocketCanPort>, CanPortError> open(std::string_view interface,
                                                                                       const CanPortOptions& options,
                                                                                       rt::Clock& clock);
  /// Uses a descriptor. `clock` must outlive the port.
  SocketCanPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept;

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override;
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] PortStatistics statistics() const noexcept override;

 private:
  [[nodiscard]] bool look_for_frame() noexcept;
  [[nodiscard]] std::optional<Frame> decode(std::size_t size) noexcept;
  void take_queue_losses(std::uint32_t total) noexcept;

  rt::FileDescriptor descriptor_;
  CanPortOptions options_;
  rt::Clock& clock_;
  PortStatistics counters_;
  bool ended_ = false;                 ///< the descriptor gives nothing any more
  bool told_end_ = false;              ///< wait_readable() has returned because of that
  bool interface_down_ = false;        ///< until a frame passes
  std::uint32_t queue_losses_ = 0;     ///< as the kernel counted them last
  std::optional<ReceivedFrame> next_;  ///< what receive() returns
  std::array<std::byte, socketcan::kFdFrameBytes> message_{};
};

}  // namespace driveline::canopen
