#pragma once

#include <functional>

#include "driveline/canopen_client/client_error.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

/// A port as those use it who wait: sends with patience, waits for frames until a time, and shows every frame to a
/// listener, so that nothing that arrives during a request is lost. Not for the cycle. One thread at a time.
class BusLink {
 public:
  /// Is shown every frame that arrives, before those who wait for it.
  using Listener = std::function<void(const ReceivedFrame&)>;
  /// Returns whether waiting is to end.
  using Stop = std::function<bool()>;

  /// The port and the clock, which must be that of the port, must outlive this.
  BusLink(CanPort& port, rt::Clock& clock) noexcept : port_(&port), clock_(&clock) {}

  /// Sets who is shown the frames; an empty function: nobody.
  void set_listener(Listener listener) { listener_ = std::move(listener); }
  /// Sets what ends waiting early; an empty function: nothing. Asked at least every 50 ms.
  void set_stop(Stop stop) { stop_ = std::move(stop); }

  /// Sends a frame; waits up to `patience` while the adapter takes none. Errors: kDown, kBusy, kNotCarried, kStopped,
  /// without a node.
  [[nodiscard]] ClientResult<void> send(const Frame& frame, std::chrono::nanoseconds patience);
  /// Returns the next frame; empty when none has come by `deadline`, waiting was stopped, or the port is down.
  [[nodiscard]] std::optional<ReceivedFrame> receive(std::chrono::nanoseconds deadline);

  /// Whether waiting is to end.
  [[nodiscard]] bool stopped() const { return stop_ && stop_(); }
  /// Whether the adapter, its connection or the bus is gone.
  [[nodiscard]] bool down() const noexcept { return port_->statistics().down; }
  /// Time on the clock of the port.
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept { return clock_->now(); }
  /// The port, for its counters.
  [[nodiscard]] CanPort& port() const noexcept { return *port_; }

 private:
  CanPort* port_;
  rt::Clock* clock_;
  Listener listener_;
  Stop stop_;
};

}  // namespace driveline::canopen
