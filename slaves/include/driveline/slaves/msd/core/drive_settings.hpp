#pragma once

#include <chrono>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

/// Settings of the drive's parts, read from the object dictionary. \rtsafe throughout.
namespace driveline::slaves::msd {

/// Returns the settings of the motion. `motor`: the actual motor; `scaling`: the active units. \rtsafe
[[nodiscard]] MotionSettings motion_settings(const ObjectDictionary& dictionary, const ServoMotor& motor,
                                             Variant variant, const Scaling& scaling) noexcept;
/// Sets 6075h and 6076h from the motor data in P 457 and P 460. \rtsafe
void follow_motor_data(ObjectDictionary& dictionary) noexcept;
/// Returns the settings of the I2t monitoring. `rated_current_a`: of the actual motor. \rtsafe
[[nodiscard]] OverloadLimits overload_limits(const ObjectDictionary& dictionary, double rated_current_a) noexcept;

/// Returns P 306. \rtsafe
[[nodiscard]] std::chrono::nanoseconds reference_cycle(const ObjectDictionary& dictionary) noexcept;
/// Whether P 306 and 60C2h are the same cycle (MSD manual 7.4.2), a multiple of 125 us (9.1). \rtsafe
[[nodiscard]] bool timing_valid(const ObjectDictionary& dictionary) noexcept;

}  // namespace driveline::slaves::msd
