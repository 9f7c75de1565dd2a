#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Result of CanPort::send().
enum class SendStatus : std::uint8_t {
  kSent,      ///< on the bus, or in the queue of the adapter
  kBusy,      ///< the queue is full; nothing was sent
  kNotValid,  ///< the frame is not possible on a bus, or the adapter cannot carry it; nothing was sent
  kDown,      ///< the adapter, its connection or the bus is gone
};

/// A frame that has arrived.
struct ReceivedFrame {
  Frame frame;                    ///< data, remote or error frame
  std::chrono::nanoseconds time;  ///< when it was received, on the port's clock
};

/// What an adapter tells of its bus.
enum class BusState : std::uint8_t {
  kUnknown,       ///< the adapter does not tell
  kErrorActive,   ///< in order
  kErrorWarning,  ///< an error counter has reached 96
  kErrorPassive,  ///< an error counter has reached 128
  kBusOff,        ///< the controller has left the bus
};

/// Counters of a port since it was opened.
struct PortStatistics {
  std::uint64_t sent = 0;                     ///< frames that send() accepted
  std::uint64_t received = 0;                 ///< frames that receive() returned, error frames included
  std::uint64_t error_frames = 0;             ///< error frames among them
  std::uint64_t lost = 0;                     ///< frames that the adapter or its connection says it lost
  std::uint64_t malformed = 0;                ///< input that is no frame and no answer of the protocol, frames of CAN
                                              ///< FD among it; it was skipped
  BusState state = BusState::kUnknown;        ///< as the adapter told it last
  std::optional<std::uint8_t> send_errors{};  ///< transmit error counter, where the adapter tells it
  std::optional<std::uint8_t> receive_errors{};  ///< receive error counter, where the adapter tells it
  bool down = false;                             ///< the adapter or its connection is gone: send() gives kDown, and
                                                 ///< nothing comes any more
};

/// The only interface to a CAN bus. A CAN interface of the kernel, the adapters and servers that other programs speak
/// to, the simulated bus in this process and the capture decorator implement it.
///
/// Only one thread at a time may use a port; another thread may take over between two calls.
class CanPort {
 public:
  virtual ~CanPort() = default;

  /// Hands one data or remote frame to the bus. Does not wait. \rtsafe
  [[nodiscard]] virtual SendStatus send(const Frame& frame) noexcept = 0;

  /// Returns the next frame that has arrived, or empty. Does not wait. The frames of this port itself do not arrive.
  /// \rtsafe
  [[nodiscard]] virtual std::optional<ReceivedFrame> receive() noexcept = 0;

  /// Waits until a frame can be received or until `deadline` on the port's clock. Returns true when a frame can be
  /// received. Returns false before the deadline once, when the connection ends while it waits; afterwards it sleeps
  /// until the deadline. \rtsafe
  virtual bool wait_readable(std::chrono::nanoseconds deadline) noexcept = 0;

  /// Returns the counters. \rtsafe
  [[nodiscard]] virtual PortStatistics statistics() const noexcept = 0;
};

}  // namespace driveline::canopen
