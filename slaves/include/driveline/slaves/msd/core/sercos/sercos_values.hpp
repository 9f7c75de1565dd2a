#pragma once

#include <cstdint>
#include <vector>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::slaves::msd {

/// Values of a drive that only the profile SERCOS has ("ServoOne User Manual SERCOS II interface", 1100.29B.2-00), in
/// the units that are in force there; their slots follow those of the drive. A member is named after its IDN: the
/// parameter 10000 + n of the device is S-0-n (lines 392-394).
///
/// Other IDNs are values of every drive, in DriveValues. With this profile the drive's units are those of SERCOS, so
/// these are the same numbers: S-0-0051 `position_actual`, S-0-0040 `velocity_actual`, S-0-0189 and P 279
/// `following_error`, P 144 to P 2261 as far as DriveValues has the parameter of that number.
struct SercosValues : SlotNumbers {
  constexpr SercosValues() noexcept : SlotNumbers(kValue.end()) {}
  // What a drive that follows cyclic setpoints reads or writes in every cycle.
  Slot<std::uint16_t> control_word{next()};              ///< S-0-0134, see master_control
  Slot<std::uint16_t> status_word{next()};               ///< S-0-0135, see drive_status
  Slot<std::int32_t> velocity_command{next()};           ///< S-0-0036
  Slot<std::int32_t> additive_velocity{next()};          ///< S-0-0037
  Slot<std::int32_t> position_command{next()};           ///< S-0-0047
  Slot<std::int16_t> torque_command{next()};             ///< S-0-0080
  Slot<std::int16_t> additive_torque{next()};            ///< S-0-0081
  Slot<std::int16_t> torque_feedback{next()};            ///< S-0-0084
  Slot<std::uint16_t> position_fraction{next()};         ///< P 3100: 1/65536 of a unit of S-0-0047
  Slot<std::int32_t> velocity_feed_forward{next()};      ///< P 3055
  Slot<std::int32_t> acceleration_feed_forward{next()};  ///< P 3056
  Slot<std::uint16_t> positioning_control{next()};       ///< S-0-0346, see positioning
  Slot<std::uint16_t> setpoint_acknowledge{next()};      ///< S-0-0419, bit 0
  Slot<std::int32_t> active_target{next()};              ///< S-0-0430
  // operation modes
  SlotArray<std::uint16_t, 4> modes{next(4)};             ///< S-0-0032 to S-0-0035
  Slot<std::int32_t> target_position{next()};             ///< S-0-0258, of the drive's interpolation
  Slot<std::uint32_t> positioning_velocity{next()};       ///< S-0-0259
  Slot<std::uint32_t> positioning_acceleration{next()};   ///< S-0-0260
  Slot<std::uint32_t> positioning_deceleration{next()};   ///< S-0-0359; 0: S-0-0260
  Slot<std::int32_t> positioning_command{next()};         ///< S-0-0282, of positioning
  Slot<std::uint16_t> positioning_mode{next()};           ///< S-0-0393
  Slot<std::uint16_t> feed_rate_override{next()};         ///< S-0-0108, 0.01 %
  Slot<std::int32_t> short_way_velocity{next()};          ///< S-0-0417
  Slot<std::uint32_t> short_way_window{next()};           ///< S-0-0418
  Slot<std::uint32_t> speed_acceleration{next()};         ///< P 3005
  Slot<std::uint32_t> speed_deceleration{next()};         ///< P 3006
  Slot<float> speed_override{next()};                     ///< P 167, %
  Slot<float> feed_forward_gain{next()};                  ///< P 3054
  Slot<std::uint16_t> feed_forward_shown{next()};         ///< P 377
  Slot<std::uint16_t> position_encoder{next()};           ///< P 522
  SlotArray<std::uint16_t, 2> encoder_channels{next(2)};  ///< P 530, P 531
  Slot<std::uint16_t> control_cycle{next()};              ///< S-0-0001, us
  // limits
  Slot<std::int32_t> positive_velocity_limit{next()};  ///< S-0-0038
  Slot<std::int32_t> negative_velocity_limit{next()};  ///< S-0-0039
  Slot<std::uint32_t> velocity_limit{next()};          ///< S-0-0091
  Slot<std::int16_t> positive_torque_limit{next()};    ///< S-0-0082
  Slot<std::int16_t> negative_torque_limit{next()};    ///< S-0-0083
  Slot<std::uint16_t> torque_limit{next()};            ///< S-0-0092
  Slot<float> speed_share{next()};                     ///< P 328, % of P 458
  Slot<float> torque_share{next()};                    ///< P 329, % of P 460
  Slot<float> negative_torque_share{next()};           ///< P 330, %
  Slot<float> positive_torque_share{next()};           ///< P 331, %
  Slot<float> online_torque_share{next()};             ///< P 332, %
  Slot<float> negative_speed_share{next()};            ///< P 333, %
  Slot<float> positive_speed_share{next()};            ///< P 334, %
  Slot<float> rated_speed{next()};                     ///< P 458, rpm
  Slot<std::uint32_t> monitored_difference{next()};    ///< S-0-0159
  Slot<std::uint32_t> tracking_limit{next()};          ///< P 742 and P 743; 0: off
  // enabling and stopping
  Slot<std::uint16_t> level_control{next()};            ///< P 144: bit 15 of S-0-0134 acts by 0 edge, 1 level
  Slot<std::uint16_t> enable_option{next()};            ///< P 156: 1 MOVE_COMMAND
  SlotArray<float, 2> jog_speeds{next(2)};              ///< P 168: fast, slow; velocity units
  Slot<std::uint32_t> quick_stop_acceleration{next()};  ///< P 2242
  Slot<std::uint16_t> reset_class_1{next()};            ///< S-0-0099: 3 resets the faults
  // real-time bits and signal words
  SlotArray<std::uint16_t, 2> control_bits{next(2)};         ///< S-0-0300, S-0-0302
  SlotArray<std::uint16_t, 2> control_bit_targets{next(2)};  ///< S-0-0301, S-0-0303
  SlotArray<std::uint16_t, 2> control_bit_numbers{next(2)};  ///< S-0-0413, S-0-0414
  SlotArray<std::uint16_t, 2> status_bits{next(2)};          ///< S-0-0304, S-0-0306
  SlotArray<std::uint16_t, 2> status_bit_sources{next(2)};   ///< S-0-0305, S-0-0307
  SlotArray<std::uint16_t, 2> status_bit_numbers{next(2)};   ///< S-0-0415, S-0-0416
  Slot<std::uint16_t> signal_status{next()};                 ///< S-0-0144
  Slot<std::uint16_t> signal_control{next()};                ///< S-0-0145
  // diagnosis
  SlotArray<std::uint16_t, 3> classes{next(3)};      ///< S-0-0011 to S-0-0013: C1D, C2D, C3D
  Slot<std::uint16_t> interface_status{next()};      ///< S-0-0014
  SlotArray<std::uint16_t, 2> class_masks{next(2)};  ///< S-0-0097, S-0-0098
  Slot<std::uint32_t> position_window{next()};       ///< S-0-0057
  Slot<std::uint32_t> standstill_window{next()};     ///< S-0-0124
  Slot<std::uint32_t> velocity_threshold{next()};    ///< S-0-0125
  Slot<std::int16_t> torque_threshold{next()};       ///< S-0-0126
  Slot<std::uint32_t> velocity_window{next()};       ///< S-0-0157
  Slot<std::uint16_t> in_position{next()};           ///< S-0-0336, bit 0
};

/// The slots of these values.
inline constexpr SercosValues kSercosValue{};

/// Returns the rows of a drive with the profile SERCOS: drive_rows() with the defaults of this profile (P 159 = 6,
/// P 165 = 8, P 370 = 3), and those of SercosValues. S-0-n is at the index of parameter 10000 + n. A table of them has
/// kSercosValue.end() fixed slots.
[[nodiscard]] std::vector<EntryRow> sercos_drive_rows(Variant variant);

}  // namespace driveline::slaves::msd
