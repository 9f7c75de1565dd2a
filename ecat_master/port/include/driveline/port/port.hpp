#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace driveline::port {

/// Longest Ethernet frame handled: 14 byte header, optional 4 byte VLAN tag, 1500 bytes of payload (no FCS).
inline constexpr std::size_t kMaxFrameBytes = 1518;

/// Result of Port::send().
enum class SendStatus : std::uint8_t {
  kSent,      ///< on the wire (or in the queue of the network interface)
  kLinkDown,  ///< no carrier, or the interface is gone
  kBusy,      ///< the queue is full; nothing was sent
  kTooLong,   ///< longer than kMaxFrameBytes; nothing was sent
};

/// A frame that came back. `bytes` belongs to the port and stays valid until the next call of receive().
struct ReceivedFrame {
  std::span<const std::byte> bytes;  ///< whole Ethernet frame without FCS
  std::chrono::nanoseconds time;     ///< receive time stamp on the port's clock
};

/// The only door to the wire. A network interface, the in-process line, a redundant pair and the decorators
/// (capture, faults) all look like this to the master.
///
/// One thread at a time uses a port; the thread may change while nobody is inside.
class Port {
 public:
  virtual ~Port() = default;

  /// Hands one Ethernet frame (without FCS, 14..kMaxFrameBytes bytes) to the wire. Does not wait. \rtsafe
  [[nodiscard]] virtual SendStatus send(std::span<const std::byte> frame) noexcept = 0;

  /// Frames that send() takes before `instant` (on the port's clock) leave then: of a port with launch times
  /// (RawSocketConfig::launch_times), which hands them to the kernel meanwhile. Every other port sends at once. Holds
  /// until the next call. \rtsafe
  virtual void hold_until(std::chrono::nanoseconds instant) noexcept { static_cast<void>(instant); }

  /// The next frame that has arrived, or nothing. Does not wait. \rtsafe
  [[nodiscard]] virtual std::optional<ReceivedFrame> receive() noexcept = 0;

  /// Waits until a frame can be received or `deadline` (on the port's clock) has passed; true in the first case.
  /// It may sleep, so a cycle calls it only when it is to sleep until its answer comes. \rtsafe
  virtual bool wait_readable(std::chrono::nanoseconds deadline) noexcept = 0;

  /// Time stamp of the last frame that send() put on the wire; of one that is held back, its launch time. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds last_send_time() const noexcept = 0;
};

}  // namespace driveline::port
