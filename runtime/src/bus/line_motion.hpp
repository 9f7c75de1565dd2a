#pragma once

#include <functional>
#include <optional>

#include "driveline/motion/control/motion_control.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/event/operation_events.hpp"

namespace driveline::runtime {

/// The axes of a running line, as seen outside the cycle: starts and stops them, and reports what happens to them.
/// Belongs to the thread that owns the master.
class LineMotion {
 public:
  /// Receives the events of the axes, in order.
  using Tell = std::function<void(EventFacts facts, Severity severity)>;

  virtual ~LineMotion() = default;

  /// Returns the object that moves the axes in the cycle.
  [[nodiscard]] virtual motion::MotionControl& control() noexcept = 0;
  /// Called when the line is in operation; may enable the axes.
  virtual void start() = 0;
  /// Brings the axes to rest and switches them off.
  virtual void request_stop() = 0;
  /// Whether the axes are off.
  [[nodiscard]] virtual bool off() const = 0;
  /// Whether the axes have completed their motion.
  [[nodiscard]] virtual bool done() const = 0;
  /// Whether the run enables all axes.
  [[nodiscard]] virtual bool enables() const = 0;
  /// Returns the phase of the axes, for progress events.
  [[nodiscard]] virtual events::Progress progress() const = 0;
  /// Reports the events of the axes since the last call.
  virtual void poll(const Tell& tell) = 0;
  /// Returns the failure that ends the run; none: there is none.
  [[nodiscard]] virtual std::optional<events::AxesStopped> failure() = 0;
  /// Call at the end, before request_stop(): reports axes in a state in which no run should end.
  virtual void judge(const Tell& tell) const { static_cast<void>(tell); }

 protected:
  LineMotion() = default;
  LineMotion(const LineMotion&) = default;
  LineMotion& operator=(const LineMotion&) = default;
};

}  // namespace driveline::runtime
