#pragma once

#include "driveline/trajectory/optional_torque.hpp"

namespace driveline::trajectory {

/// What one axis shall do at one instant. The unit of length is that of the axis: rad for a rotary axis, m for a
/// linear one.
struct AxisSetpoint {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  /// Nm or N, from a source that computes it itself: in torque mode it is all that drives the axis, otherwise the
  /// feed-forward. None: what the inertia needs for the acceleration, and in torque mode what the master's loops say.
  OptionalTorque torque{};
};

}  // namespace driveline::trajectory
