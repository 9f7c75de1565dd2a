#pragma once

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Returns an axis smoothly to a path that may be moving. The deviation from the path goes to zero with the part of the
/// limits that the path leaves, at most a tenth of the acceleration, so that the acceleration of the axis is nearly
/// that of the path; an axis that is faster than its limit brakes harder. For axes whose control loops respond late,
/// such as loops closed over the bus. Rejoin is faster, but its acceleration jumps from one limit to the other. A path
/// that jumps takes the axis with it. A plain value without heap memory.
class Deviation {
 public:
  Deviation() = default;
  /// Starts at this position (rad or m) and velocity; the limits must be positive and finite.
  Deviation(double position, double velocity, const AxisLimits& limits) noexcept
      : position_(position), velocity_(velocity), limits_(limits) {}

  /// Returns the setpoint one step of `period_s` later, when the path is at `target`; with the torque of `target`.
  /// \rtsafe
  [[nodiscard]] AxisSetpoint step(const AxisSetpoint& target, double period_s) noexcept;
  /// Reports that `time_s` has passed without a step, while path and axis continued at their velocities. \rtsafe
  void skip(double time_s) noexcept {
    if (begun_) position_ += time_s * velocity_;
  }
  /// Whether the last setpoint was on the path itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return joined_; }

 private:
  void begin(const AxisSetpoint& target, double period_s) noexcept;
  [[nodiscard]] double allowed(double path, double deviation, double period_s) const noexcept;

  double position_ = 0.0;       ///< before the first step: position of the axis; afterwards: deviation
  double velocity_ = 0.0;       ///< before the first step: velocity of the axis; afterwards: its deviation
  double last_velocity_ = 0.0;  ///< last velocity setpoint of the axis
  AxisLimits limits_{};
  bool begun_ = false;
  bool joined_ = false;
};

}  // namespace driveline::trajectory
