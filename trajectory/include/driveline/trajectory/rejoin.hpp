#pragma once

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Takes an axis from any position back onto a path that may be moving, without a jump: from step to step the velocity
/// changes by no more than max_acceleration allows, and its magnitude stays within max_velocity or that of the path.
/// The axis catches up if its limits exceed what the path needs. A plain value without memory of its own.
class Rejoin {
 public:
  Rejoin() = default;
  /// Begins at a position (rad or m) and velocity; the limits must be positive and finite.
  Rejoin(double position, double velocity, const AxisLimits& limits) noexcept
      : position_(position), velocity_(velocity), limits_(limits) {}

  /// The setpoint one step of `period_s` later, when the path is at `target`. \rtsafe
  [[nodiscard]] AxisSetpoint step(const AxisSetpoint& target, double period_s) noexcept;
  /// Whether the setpoint of the last step was that of the path itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return joined_; }

 private:
  double position_ = 0.0;
  double velocity_ = 0.0;
  AxisLimits limits_{};
  bool joined_ = false;
};

}  // namespace driveline::trajectory
