#pragma once

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Takes an axis back to a path that may be moving, gently: what it deviates from the path goes to zero by what the
/// path leaves of the limits, at most a tenth of the acceleration, so that the acceleration of the axis is nearly that
/// of the path all the way; an axis that is faster than its limit is braked harder. For axes whose loops answer late,
/// as those that are closed over the bus do; Rejoin is faster, and its acceleration leaps from one limit to the other.
/// A path that leaps takes the axis with it. A plain value without memory of its own.
class Deviation {
 public:
  Deviation() = default;
  /// Begins at this position (rad or m) and velocity; the limits must be positive and finite.
  Deviation(double position, double velocity, const AxisLimits& limits) noexcept
      : position_(position), velocity_(velocity), limits_(limits) {}

  /// The setpoint one step of `period_s` later, when the path is at `target`; with the torque of `target`. \rtsafe
  [[nodiscard]] AxisSetpoint step(const AxisSetpoint& target, double period_s) noexcept;
  /// `time_s` has gone by without a step, in which path and axis went on at their velocities. \rtsafe
  void skip(double time_s) noexcept {
    if (begun_) position_ += time_s * velocity_;
  }
  /// Whether the setpoint of the last step was that of the path itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return joined_; }

 private:
  void begin(const AxisSetpoint& target, double period_s) noexcept;
  [[nodiscard]] double allowed(double path, double deviation, double period_s) const noexcept;

  double position_ = 0.0;       ///< before the first step of the axis, then its deviation
  double velocity_ = 0.0;       ///< the same
  double last_velocity_ = 0.0;  ///< of the axis
  AxisLimits limits_{};
  bool begun_ = false;
  bool joined_ = false;
};

}  // namespace driveline::trajectory
