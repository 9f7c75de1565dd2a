#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace driveline::port {

/// Longest Ethernet frame handled, in bytes: 14 of header, optional 4 of VLAN tag, 1500 of payload (no FCS).
inline constexpr std::size_t kMaxFrameBytes = 1518;

/// Result of Port::send().
enum class SendStatus : std::uint8_t {
  kSent,      ///< on the wire (or in the queue of the network interface)
  kLinkDown,  ///< no carrier, or the interface is gone
  kBusy,      ///< the queue is full; nothing was sent
  kTooLong,   ///< longer than kMaxFrameBytes; nothing was sent
};

/// A received frame. `bytes` belongs to the port and stays valid until the next call of receive().
struct ReceivedFrame {
  std::span<const std::byte> bytes;  ///< whole Ethernet frame without FCS
  std::chrono::nanoseconds time;     ///< receive time stamp on the port's clock
};

/// The only interface to the wire. A network interface, the in-process line, a redundant pair and the decorators
/// (capture, faults) all implement it.
///
/// Only one thread at a time may use a port; another thread may take over between two calls.
class Port {
 public:
  virtual ~Port() = default;

  /// Hands one Ethernet frame (without FCS, 14..kMaxFrameBytes bytes) to the wire. Does not wait. \rtsafe
  [[nodiscard]] virtual SendStatus send(std::span<const std::byte> frame) noexcept = 0;

  /// Sets the launch time of the frames that send() takes before `instant` (on the port's clock). A port with launch
  /// times (RawSocketConfig::launch_times) hands them to the kernel at once and the kernel sends them at `instant`;
  /// every other port sends at once. Holds until the next call. \rtsafe
  virtual void hold_until(std::chrono::nanoseconds instant) noexcept { static_cast<void>(instant); }

  /// The next frame that has arrived, or empty. Does not wait. \rtsafe
  [[nodiscard]] virtual std::optional<ReceivedFrame> receive() noexcept = 0;

  /// Waits until a frame can be received or until `deadline` (on the port's clock). Returns true when a frame can be
  /// received. It may sleep: the cycle calls it only where it may sleep until its answer arrives. \rtsafe
  virtual bool wait_readable(std::chrono::nanoseconds deadline) noexcept = 0;

  /// Send time stamp of the last frame that send() accepted; its launch time when it is held back. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds last_send_time() const noexcept = 0;
};

}  // namespace driveline::port
