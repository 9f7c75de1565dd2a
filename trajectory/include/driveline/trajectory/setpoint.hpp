#pragma once

#include "driveline/trajectory/optional_torque.hpp"

namespace driveline::trajectory {

/// Setpoint of an axis at one instant. The unit of length is that of the axis: rad for a rotary axis, m for a linear
/// one.
struct AxisSetpoint {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  /// Torque in Nm or N from a source that computes it: in torque mode the complete demand, otherwise the feed-forward.
  /// None: the feed-forward is inertia times acceleration, and in torque mode the master closes the control loops.
  OptionalTorque torque{};
};

}  // namespace driveline::trajectory
