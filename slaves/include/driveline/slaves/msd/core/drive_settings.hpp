#pragma once

#include <chrono>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

/// Settings of the drive's parts, from the object dictionary. All of it \rtsafe.
namespace driveline::slaves::msd {

/// Settings of the motion. `motor`: the real one; `scaling`: the units in force. \rtsafe
[[nodiscard]] MotionSettings motion_settings(const ObjectDictionary& dictionary, const ServoMotor& motor,
                                             Variant variant, const Scaling& scaling) noexcept;
/// Sets 6075h and 6076h from the motor data in P 457 and P 460. \rtsafe
void follow_motor_data(ObjectDictionary& dictionary) noexcept;
/// Settings of the I2t monitoring. `rated_current_a`: of the real motor. \rtsafe
[[nodiscard]] OverloadLimits overload_limits(const ObjectDictionary& dictionary, double rated_current_a) noexcept;
/// 605Ah-605Ch, 605Eh, P 154. \rtsafe
[[nodiscard]] OptionCodes option_codes(const ObjectDictionary& dictionary) noexcept;

/// The control word comes from the bus (P 159). \rtsafe
[[nodiscard]] bool remote(const ObjectDictionary& dictionary) noexcept;
/// 6040h, 0 when it does not come from the bus. \rtsafe
[[nodiscard]] std::uint16_t control_word(const ObjectDictionary& dictionary) noexcept;
/// Setpoints come from the bus (P 165). \rtsafe
[[nodiscard]] bool references_from_bus(const ObjectDictionary& dictionary) noexcept;
/// Setpoints for the mode that 6060h asks for, or `in_force` when it asks for none of this drive: setpoints sent with a
/// new mode are for that mode. \rtsafe
[[nodiscard]] Setpoints setpoints(const ObjectDictionary& dictionary, OperationMode in_force) noexcept;

/// P 306. \rtsafe
[[nodiscard]] std::chrono::nanoseconds reference_cycle(const ObjectDictionary& dictionary) noexcept;
/// P 306 and 60C2h must be the same cycle (MSD manual 7.4.2), a multiple of 125 us (9.1). \rtsafe
[[nodiscard]] bool timing_valid(const ObjectDictionary& dictionary) noexcept;

}  // namespace driveline::slaves::msd
