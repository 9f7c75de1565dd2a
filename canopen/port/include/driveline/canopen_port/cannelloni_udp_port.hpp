#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_wire/cannelloni.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::canopen {

/// A tunnel of cannelloni over UDP (doc/udp_format.md of cannelloni, version 2). Each frame leaves in a packet of its
/// own at once. Packets that are missing in the sequence numbers of the far end count as lost, one each; late ones are
/// used. Nobody answers when the tunnel is opened: if nothing listens at the far end, send() gives kDown until
/// something does. Error frames and frames of CAN FD are passed over.
class CannelloniUdpPort final : public CanPort {
 public:
  /// Sends to "HOST:PORT", and receives from there at the local port `local`; 0: any.
  [[nodiscard]] static tl::expected<std::unique_ptr<CannelloniUdpPort>, CanPortError> open(std::string_view address,
                                                                                           std::uint16_t local,
                                                                                           rt::Clock& clock);
  /// Uses a connected datagram socket. `clock` must outlive the port.
  CannelloniUdpPort(rt::FileDescriptor socket, rt::Clock& clock) noexcept;

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override;
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] PortStatistics statistics() const noexcept override { return counters_; }

 private:
  static constexpr std::size_t kPacketBytes = 65'536;  ///< more than any packet of UDP has

  [[nodiscard]] bool look_for_frame() noexcept;
  [[nodiscard]] bool take_frame() noexcept;
  void start_packet(std::size_t size) noexcept;

  rt::FileDescriptor socket_;
  rt::Clock& clock_;
  PortStatistics counters_;
  std::uint8_t sequence_ = 0;                 ///< of the next packet to send
  std::optional<std::uint8_t> expected_;      ///< sequence number of the next packet to come
  std::optional<ReceivedFrame> next_;         ///< what receive() returns
  std::optional<cannelloni::Reader> reader_;  ///< of the packet in packet_
  std::array<std::byte, kPacketBytes> packet_{};
};

}  // namespace driveline::canopen
