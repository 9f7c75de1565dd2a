#pragma once

#include <cstddef>

namespace driveline::motion {

/// Settings of two axes that carry one beam. Lengths are rad or m.
struct GantrySettings {
  std::size_t leader = 0;    ///< the commanded axis
  std::size_t follower = 0;  ///< the axis that follows
  double offset = 0.0;       ///< position of the follower minus that of the leader when square, in drive positions
  /// `offset` is relative to the marks of both axes, which homing finds; before, the axes keep their present offset.
  bool when_homed = false;
  double skew_warning = 0.0;         ///< skew at which a warning is given, magnitude; not above the limit
  double skew_limit = 0.0;           ///< skew at which both axes stop; above 0
  double square_velocity = 0.0;      ///< velocity of squaring the follower, rad/s or m/s; above 0
  double square_acceleration = 0.0;  ///< rad/s^2 or m/s^2; above 0
  bool square_when_enabled = false;  ///< a pair with too much skew when it is enabled is squared, not refused
};

}  // namespace driveline::motion
