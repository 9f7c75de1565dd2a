#pragma once

#include <cstdint>
#include <optional>

#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion {

/// Scales between SI units and those of a drive, signed by the direction of the axis.
struct DriveScales {
  double increments = 1.0;       ///< increments per rad or m; per second for velocities
  double nm_per_permille = 1.0;  ///< Nm or N that correspond to 1 per mille of torque
};

/// Positions that a drive reports, in its increments. They wrap around at the ends of its range.
struct DriveCounts {
  std::int32_t actual = 0;               ///< actual position
  std::optional<std::int32_t> demand{};  ///< demand of the position loop; none: not in the process data
};

/// Outputs of an exchange. Velocities and torques are those of the drive, in SI units and the direction of the axis.
struct DriveTargets {
  cia402::Goal goal = cia402::Goal::kDisabled;                    ///< state to bring the drive to
  snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< its state now, as far as the axis trusts it
  bool reset_fault = false;                                       ///< resets a fault instead
  cia402::Mode mode = cia402::Mode::kCyclicPosition;              ///< mode of operation
  std::int32_t position = 0;                                      ///< in increments
  double velocity = 0.0;                                          ///< without `velocity_offset`, rad/s or m/s
  double velocity_offset = 0.0;                                   ///< rad/s or m/s
  double torque = 0.0;                                            ///< with `torque_offset`, Nm or N
  double torque_offset = 0.0;                                     ///< Nm or N
};

}  // namespace driveline::motion
