#pragma once

#include <cstdint>
#include <limits>

#include "driveline/snapshot/snapshot.hpp"

namespace driveline::motion {

/// Decoded inputs of an axis; an invalid cycle does not change them.
struct AxisInputs {
  std::uint16_t status_word = 0;                                  ///< object 6041h
  std::uint16_t error_code = 0;                                   ///< 603Fh
  std::int8_t mode = 0;                                           ///< 6061h
  bool follows = false;                                           ///< the drive reports that it follows setpoints
  snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< CiA 402 state from the status word
  double position = 0.0;                                          ///< rad or m; continues beyond the 32-bit range
  double velocity = 0.0;                                          ///< rad/s or m/s
  double torque = 0.0;                                            ///< Nm or N
  double drive_following_error = 0.0;  ///< following error reported by the drive (60F4h), rad or m
  /// Demand values of the drive's loops (6062h, 606Bh, 6074h); each is NaN where it is not mapped.
  double demand_position = std::numeric_limits<double>::quiet_NaN();  ///< rad or m
  double demand_velocity = std::numeric_limits<double>::quiet_NaN();  ///< rad/s or m/s
  double demand_torque = std::numeric_limits<double>::quiet_NaN();    ///< Nm or N
  std::int64_t digital_inputs = snapshot::kNoDigitalInputs;           ///< 60FDh; kNoDigitalInputs: not mapped
};

}  // namespace driveline::motion
