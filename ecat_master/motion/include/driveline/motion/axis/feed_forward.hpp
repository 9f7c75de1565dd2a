#pragma once

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Torque that an axis needs besides that of its inertia, for the feed-forward: friction and the weight of its load.
/// Torques are Nm or N, in the direction of the axis.
struct FeedForward {
  double viscous_friction = 0.0;  ///< torque per velocity: Nm s/rad or N s/m; 0 or more
  double coulomb_friction = 0.0;  ///< dry friction; 0 or more
  /// Velocity above which the dry friction counts in full, rad/s or m/s, above 0. Below it, its share rises with the
  /// velocity, so that it is zero at standstill and has no step where the axis reverses.
  double coulomb_velocity = 0.2;
  double gravity = 0.0;        ///< torque that holds the weight; positive: gravity pulls in negative direction
  double pendulum = 0.0;       ///< torque that holds a pendulum horizontally; 0 or more
  double pendulum_zero = 0.0;  ///< position at which the pendulum hangs down, rad

  /// Torque at this position and velocity, Nm or N. \rtsafe
  [[nodiscard]] double torque(const trajectory::AxisSetpoint& setpoint) const noexcept;
  /// Whether any torque is configured. \rtsafe
  [[nodiscard]] bool any() const noexcept {
    return viscous_friction > 0.0 || coulomb_friction > 0.0 || gravity > 0.0 || gravity < 0.0 || pendulum > 0.0;
  }
};

}  // namespace driveline::motion
