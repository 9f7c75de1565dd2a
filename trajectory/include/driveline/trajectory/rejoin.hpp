#pragma once

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Returns an axis from any position to a path that may be moving, without a jump: from step to step the velocity
/// changes by no more than max_acceleration allows, and its magnitude stays within max_velocity or the velocity of the
/// path. The axis catches up if its limits exceed the demand of the path. A plain value without heap memory.
class Rejoin {
 public:
  Rejoin() = default;
  /// Starts at a position (rad or m) and velocity; the limits must be positive and finite.
  Rejoin(double position, double velocity, const AxisLimits& limits) noexcept
      : position_(position), velocity_(velocity), limits_(limits) {}

  /// Returns the setpoint one step of `period_s` later, when the path is at `target`. \rtsafe
  [[nodiscard]] AxisSetpoint step(const AxisSetpoint& target, double period_s) noexcept;
  /// Whether the last setpoint was on the path itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return joined_; }

 private:
  double position_ = 0.0;
  double velocity_ = 0.0;
  AxisLimits limits_{};
  bool joined_ = false;
};

}  // namespace driveline::trajectory
