#pragma once

#include "driveline/trajectory/optional_torque.hpp"

namespace driveline::trajectory {

/// What one axis shall do at one instant. The unit of length is that of the axis: rad for a rotary axis, m for a
/// linear one.
struct AxisSetpoint {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  /// Torque in Nm or N, from a source that computes it: in torque mode the whole demand, otherwise the feed-forward.
  /// None: the feed-forward is inertia times acceleration, and in torque mode the master closes its loops.
  OptionalTorque torque{};
};

}  // namespace driveline::trajectory
