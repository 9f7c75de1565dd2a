#pragma once

#include <array>
#include <deque>
#include <optional>

#include "driveline/canopen_wire/cannelloni.hpp"
#include "driveline/canopen_wire/cannelloni_tcp.hpp"
#include "driveline/slaves/can/door.hpp"

namespace driveline::slaves::can {

/// A client that speaks the protocol of cannelloni, a tunnel for CAN frames. Data and remote frames pass in both
/// directions; error frames and frames of CAN FD are left out.
class CannelloniDoor : public Door {
 public:
  static constexpr std::size_t kBacklog = 1024;  ///< frames of a client that wait for room in its controller's queue

  void transmitted(const Frame& frame, nanoseconds now) override;
  void error_state_changed(ErrorState state, nanoseconds now) override;

 protected:
  /// Sends a frame as soon as the queue of the controller has room; refused when too many wait.
  void transmit(const Frame& frame);
  void left() noexcept override { backlog_.clear(); }

 private:
  std::deque<Frame> backlog_;
};

/// A client in UDP (cannelloni, doc/udp_format.md, version 2): input() takes one packet, output() begins with one of
/// piece() bytes. Frames wait up to kLongestWait for others that go into the same packet, as those of the tool wait for
/// its buffer time-out. Gaps in the sequence numbers of the client are counted as missing packets; a packet behind the
/// newest one is late and taken.
class CannelloniUdpDoor final : public CannelloniDoor {
 public:
  /// Ethernet's 1500 bytes without the headers of IPv4 and UDP.
  static constexpr std::size_t kPacketBytes = 1500 - 20 - 8;
  static constexpr nanoseconds kLongestWait = std::chrono::milliseconds{1};  ///< of a frame in an incomplete packet

  /// Whether the bytes are a packet of this protocol, as far as its header tells.
  [[nodiscard]] static bool is_packet(std::string_view bytes) noexcept;

  void input(std::string_view bytes, nanoseconds now) override;
  void receive(const Frame& frame, nanoseconds now) override;
  void advance(nanoseconds now) override;
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return send_at_; }
  [[nodiscard]] std::size_t piece() const noexcept override { return sizes_.empty() ? 0 : sizes_.front(); }
  void taken(std::size_t bytes) override;

 private:
  void restart() override;
  void left() noexcept override;
  void finish_packet();

  std::array<std::byte, kPacketBytes> buffer_{};
  std::optional<canopen::cannelloni::Writer> packet_;  ///< writes into buffer_
  nanoseconds send_at_ = kNever;
  std::deque<std::size_t> sizes_;  ///< of the packets in output()
  std::uint8_t sequence_ = 0;
  std::optional<std::uint8_t> expected_;  ///< sequence number of the client's next packet
};

/// A client in TCP (cannelloni, doc/tcp_protocol.md, version 1): a greeting of both sides, then frames.
class CannelloniTcpDoor final : public CannelloniDoor {
 public:
  void input(std::string_view bytes, nanoseconds now) override;
  void receive(const Frame& frame, nanoseconds now) override;

 private:
  [[nodiscard]] bool greeted() const noexcept { return greeted_ == canopen::cannelloni::kTcpGreeting.size(); }
  void restart() override;
  void greet(char letter);
  void refuse_client();

  std::size_t greeted_ = 0;  ///< bytes of the client's greeting so far
  canopen::cannelloni::StreamReader reader_;
};

}  // namespace driveline::slaves::can
