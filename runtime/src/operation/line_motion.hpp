#pragma once

#include <functional>
#include <optional>

#include "driveline/ecat_master/cyclic/motion_control.hpp"
#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

/// The axes of a running line, seen from beside the cycle: what starts them, stops them, and tells what happens to
/// them. Belongs to the thread that owns the master.
class LineMotion {
 public:
  /// Receives what happens to the axes, in order.
  using Tell = std::function<void(EventFacts facts, Severity severity)>;

  virtual ~LineMotion() = default;

  /// What moves the axes in the cycle.
  [[nodiscard]] virtual ecat_master::MotionControl& control() noexcept = 0;
  /// The line is in operation: the axes may be enabled.
  virtual void start() = 0;
  /// The axes are to come to rest and to be switched off.
  virtual void request_stop() = 0;
  /// They are off.
  [[nodiscard]] virtual bool off() const = 0;
  /// They have done all that they were to do.
  [[nodiscard]] virtual bool done() const = 0;
  /// Whether the run was to enable them all.
  [[nodiscard]] virtual bool enables() const = 0;
  /// What they do, for progress.
  [[nodiscard]] virtual events::Progress progress() const = 0;
  /// Tells what has happened to the axes since the last look.
  virtual void look(const Tell& tell) = 0;
  /// The failure by which the run cannot go on; none: there is none.
  [[nodiscard]] virtual std::optional<events::AxesStopped> failure() = 0;
  /// At the end, before request_stop(): tells of axes that were left in a state in which no run should end.
  virtual void judge(const Tell& tell) const { static_cast<void>(tell); }

 protected:
  LineMotion() = default;
  LineMotion(const LineMotion&) = default;
  LineMotion& operator=(const LineMotion&) = default;
};

}  // namespace driveline::runtime
