#pragma once

#include <chrono>

#include "driveline/canopen_wire/frame.hpp"
#include "driveline/slaves/can/error_counters.hpp"

/// A CAN bus on virtual time: arbitration, acknowledge, error counters and faults to the bit, in whole nanoseconds.
namespace driveline::slaves::can {

using canopen::Frame;
using std::chrono::nanoseconds;

/// A time that never comes.
inline constexpr nanoseconds kNever = nanoseconds::max();

class Controller;

/// What is behind a CAN controller: a drive, a master, a tool. All functions are called by the thread that advances the
/// bus; `now` never decreases.
class Node {
 public:
  virtual ~Node() = default;
  /// The node is on the bus; `controller` outlives it and is where it sends frames.
  virtual void connected(Controller& controller) = 0;
  /// A frame of another node has passed, or an error frame for a controller that reports them.
  virtual void receive(const Frame& frame, nanoseconds now) = 0;
  /// Does what is due at `now`; called when next_wake() has come.
  virtual void advance(nanoseconds now) = 0;
  /// When advance() has something to do; kNever for nothing. Asked after every call of the functions above.
  [[nodiscard]] virtual nanoseconds next_wake() const noexcept = 0;
  /// A frame of this node has been sent and acknowledged.
  virtual void transmitted(const Frame& frame, nanoseconds now);
  /// The controller has another error state.
  virtual void error_state_changed(ErrorState state, nanoseconds now);
};

}  // namespace driveline::slaves::can
