#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/port/interface_port.hpp"
#include "driveline/port/launch_times.hpp"
#include "driveline/port/port_error.hpp"
#include "driveline/port/receive_ring.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::port {

/// Settings of a RawSocketPort.
struct RawSocketConfig {
  std::string interface;  ///< name as in `ip link`, at most 15 characters

  /// Hands frames to the driver directly, bypassing the queueing discipline (packet(7), PACKET_QDISC_BYPASS). Saves
  /// about a microsecond and its jitter per frame, and send() learns that the link is down or the transmit ring is
  /// full. The price: no traffic shaping and no queue when the ring is full; the frame is refused with kBusy. Switch it
  /// off if the interface is shared with bulk traffic that a queueing discipline limits; the kernel then discards
  /// frames silently while there is no carrier.
  bool bypass_queue = true;

  /// SO_PRIORITY of outgoing frames, 0..6 (7 and above need CAP_NET_ADMIN). Selects the band of the queueing
  /// discipline and, on network cards with several, the transmit queue. 6 is the kernel's "interactive".
  int priority = 6;

  /// Receives through memory shared with the kernel (ReceiveRing) instead of a system call per poll: a cycle on a veth
  /// pair costs a tenth less, and a thread that spins on receive() stays out of the kernel. Falls back to system calls
  /// where the kernel offers no ring.
  bool receive_ring = true;

  /// ReceivedFrame::time is the time at which the kernel received the frame, not the time at which receive() found it.
  /// For a simulated line, whose clocks must stamp frames on arrival, as slave controllers do, and not when a thread
  /// wakes up. If the machine's clock is set while a frame waits, the time of that frame is wrong.
  bool arrival_times = false;

  /// Frames leave at the instant of Port::hold_until(), held by the queueing discipline that find_launch_times() found
  /// (bypass_queue then has no effect, because it would skip that discipline). The sending thread may wake up early by
  /// its jitter without the frame leaving early. A frame without a launch time leaves later by LaunchTimes::ahead.
  /// Needs CAP_NET_ADMIN for every clock but CLOCK_MONOTONIC.
  std::optional<LaunchTimes> launch_times{};
};

/// Counters of a RawSocketPort.
struct RawSocketStatistics {
  std::uint64_t sent = 0;           ///< frames handed to the driver
  std::uint64_t send_failures = 0;  ///< frames refused for any reason
  std::uint64_t received = 0;       ///< frames returned by receive()
  std::uint64_t too_short = 0;      ///< discarded: too short for an EtherCAT header
  std::uint64_t too_long = 0;       ///< discarded: longer than kMaxFrameBytes
};

/// EtherCAT on a network interface of this machine, through an AF_PACKET socket bound to EtherType 0x88A4.
///
/// - send() and receive() do not wait. send() makes one system call, receive() none (one without a receive ring); a few
///   more when a frame is refused or discarded. The real-time thread spins on receive() up to its deadline.
/// - Time stamps: send() takes the time just before its system call, receive() when it has found the frame, so that the
///   difference is the whole cost of the exchange for the caller; RawSocketConfig::arrival_times changes the latter.
/// - Own frames: the frames of a line come back with the master's address as source (the first slave sets bit 0x02 of
///   the first octet, ETG.1000.4 5.3.2) and a broadcast destination, so no promiscuous mode is needed. The port never
///   receives what it has sent itself, only what arrives.
/// - Pulled cable: send() reports kLinkDown. The kernel notices up to a second late; until then refused frames are
///   reported as kBusy.
/// - VLAN: the kernel removes an 802.1Q tag before the frame arrives here; a tagged frame looks like an untagged one.
/// - Both ends of a cable may be RawSocketPorts: a master and a simulated line.
///
/// The clock must run in real time (MonotonicClock): it gives the time stamps and the deadline of wait_readable().
class RawSocketPort final : public InterfacePort {
 public:
  /// Opens the interface, which must exist, carry Ethernet and be up. Needs CAP_NET_RAW. `clock` must outlive the port.
  [[nodiscard]] static tl::expected<std::unique_ptr<RawSocketPort>, PortError> open(const RawSocketConfig& config,
                                                                                    const rt::Clock& clock);

  RawSocketPort(const RawSocketPort&) = delete;
  RawSocketPort& operator=(const RawSocketPort&) = delete;
  ~RawSocketPort() override = default;

  /// kTooLong also for a frame longer than the MTU of the interface; kBusy also for a frame that the kernel refuses for
  /// any other reason. \rtsafe
  [[nodiscard]] SendStatus send(std::span<const std::byte> frame) noexcept override;

  void hold_until(std::chrono::nanoseconds instant) noexcept override { hold_until_ = instant; }

  /// \rtsafe
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;

  /// May also return true for a frame that receive() then discards (see RawSocketStatistics).
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;

  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_time_; }

  [[nodiscard]] const wire::MacAddress& mac() const noexcept override { return mac_; }

  /// Whether frames come through memory shared with the kernel. \rtsafe
  [[nodiscard]] bool has_receive_ring() const noexcept { return ring_.has_value(); }

  /// The socket descriptor, for waiting on several sockets at once.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }

  [[nodiscard]] bool link_up() const noexcept override;
  [[nodiscard]] std::string access_method() const override;

  /// Counters so far. Any thread. \rtsafe
  [[nodiscard]] RawSocketStatistics statistics() const noexcept;

 private:
  /// A frame as the kernel delivers it: as many bytes as fit, and the true length.
  using Arrival = ReceiveRing::Frame;

  RawSocketPort(rt::FileDescriptor socket, std::optional<ReceiveRing> ring, const RawSocketConfig& config, int index,
                const wire::MacAddress& mac, const rt::Clock& clock);

  std::optional<Arrival> take() noexcept;
  [[nodiscard]] ssize_t hand_over(std::span<const std::byte> frame, std::chrono::nanoseconds launch) noexcept;
  [[nodiscard]] std::chrono::nanoseconds time_of(const Arrival& arrival) noexcept;
  SendStatus classify_failure(int error_number) const noexcept;

  rt::FileDescriptor socket_;
  std::optional<ReceiveRing> ring_;
  std::string interface_;
  int index_;
  wire::MacAddress mac_;
  bool arrival_times_;
  std::optional<LaunchTimes> launch_times_;
  const rt::Clock& clock_;
  std::chrono::nanoseconds hold_until_{};
  std::chrono::nanoseconds last_send_time_{};
  std::chrono::nanoseconds last_arrival_{};
  std::array<std::byte, kMaxFrameBytes> buffer_{};  ///< receive buffer when there is no ring

  rt::Counter sent_;
  rt::Counter send_failures_;
  rt::Counter received_;
  rt::Counter too_short_;
  rt::Counter too_long_;
};

}  // namespace driveline::port
