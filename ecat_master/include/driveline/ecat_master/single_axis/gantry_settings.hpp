#pragma once

#include <cstddef>

namespace driveline::ecat_master {

/// Two axes that carry one beam. Lengths are rad or m.
struct GantrySettings {
  std::size_t leader = 0;    ///< axis that is commanded
  std::size_t follower = 0;  ///< axis that goes with it
  double offset = 0.0;       ///< position of the follower less that of the leader, as drives count, when square
  /// With it the offset is that of the marks of both axes, which homing finds; before, the axes stay as they stand.
  bool when_homed = false;
  double skew_warning = 0.0;         ///< of the skew, magnitude; not above the limit
  double skew_limit = 0.0;           ///< beyond it both stop; above 0
  double square_velocity = 0.0;      ///< with which the follower is squared, rad/s or m/s; above 0
  double square_acceleration = 0.0;  ///< rad/s^2 or m/s^2; above 0
  bool square_when_enabled = false;  ///< what is out of skew when it is enabled is squared, too, and not refused
};

}  // namespace driveline::ecat_master
