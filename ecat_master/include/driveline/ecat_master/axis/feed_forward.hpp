#pragma once

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// What an axis needs besides the torque of its inertia, for the feed-forward: friction, and the weight of what it
/// carries. Torques are Nm or N, of the axis as its increments count it.
struct FeedForward {
  double viscous_friction = 0.0;  ///< torque per velocity: Nm s/rad or N s/m; 0 or more
  double coulomb_friction = 0.0;  ///< dry friction; 0 or more
  /// Velocity from which on the dry friction counts in full, rad/s or m/s, above 0. Below it the share of it rises with
  /// the velocity, so that there is none at standstill and no step where the axis turns round.
  double coulomb_velocity = 0.2;
  double gravity = 0.0;        ///< torque that holds a weight anywhere; positive: it pulls in negative direction
  double pendulum = 0.0;       ///< torque that holds a pendulum stretched out sideways; 0 or more
  double pendulum_zero = 0.0;  ///< position in rad at which it hangs down

  /// Torque at this position and velocity. \rtsafe
  [[nodiscard]] double torque(const trajectory::AxisSetpoint& setpoint) const noexcept;
  /// Whether there is any. \rtsafe
  [[nodiscard]] bool any() const noexcept {
    return viscous_friction > 0.0 || coulomb_friction > 0.0 || gravity > 0.0 || gravity < 0.0 || pendulum > 0.0;
  }
};

}  // namespace driveline::ecat_master
