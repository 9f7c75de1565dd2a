#pragma once

#include <cstdint>
#include <numbers>

#include "driveline/slaves/od/slot.hpp"

namespace driveline::slaves::msd {

/// One revolution per minute in rad/s.
inline constexpr double kRpm = 2.0 * std::numbers::pi / 60.0;
/// Factor from the amplitude of a phase voltage to volts rms between phases, the unit of P 312: the root of 3/2.
inline constexpr double kLineRms = 1.224744871391589049098642;
/// Value of a window that disables its monitoring (CiA 402, e.g. 6065h and 6067h).
inline constexpr std::uint32_t kWindowOff = 0xFFFFFFFF;

/// P 33: texts of the fault ([0]) and of the active warnings.
inline constexpr std::uint16_t kMessagesIndex = 0x2000 + 33;

/// Values of the object dictionary that the drive uses, by name. Rows of the table refer to them; aliases refer to the
/// same value.
struct DriveValues : SlotNumbers {
  constexpr DriveValues() noexcept : SlotNumbers(0) {}
  // What a drive that follows cyclic setpoints reads or writes in every cycle, in few cache lines.
  Slot<std::uint16_t> control_word{next()};            ///< 6040h
  Slot<std::int8_t> mode{next()};                      ///< 6060h
  Slot<std::int32_t> target_position{next()};          ///< 607Ah
  Slot<std::int32_t> target_velocity{next()};          ///< 60FFh
  Slot<std::int16_t> target_torque{next()};            ///< 6071h
  Slot<std::int32_t> velocity_offset{next()};          ///< 60B1h
  Slot<std::int16_t> torque_offset{next()};            ///< 60B2h
  Slot<std::int32_t> interpolation_data{next()};       ///< 60C1h:01
  Slot<std::uint16_t> touch_probe_function{next()};    ///< 60B8h
  Slot<std::uint32_t> physical_outputs{next()};        ///< 60FEh:01
  Slot<std::uint16_t> reference_source{next()};        ///< P 165
  Slot<std::uint16_t> status_word{next()};             ///< 6041h
  Slot<std::int8_t> mode_display{next()};              ///< 6061h
  Slot<std::int32_t> position_actual{next()};          ///< 6064h
  Slot<std::int32_t> velocity_actual{next()};          ///< 606Ch
  Slot<std::int16_t> torque_actual{next()};            ///< 6077h
  Slot<std::int32_t> following_error{next()};          ///< 60F4h
  Slot<std::int32_t> position_demand{next()};          ///< 6062h
  Slot<std::uint16_t> error_code{next()};              ///< 603Fh
  Slot<std::uint8_t> dummy_byte{next()};               ///< P 2055
  Slot<std::uint32_t> following_error_window{next()};  ///< 6065h
  Slot<std::uint32_t> position_window{next()};         ///< 6067h
  Slot<std::uint16_t> position_window_time{next()};    ///< 6068h
  // settings, and the rest
  Slot<std::uint8_t> error_register{next()};                  ///< 1001h
  Slot<std::uint8_t> error_count{next()};                     ///< 1003h:00
  Slot<std::uint32_t> last_error{next()};                     ///< 1003h:01
  Slot<std::uint32_t> store_command{next()};                  ///< 1010h:01
  Slot<std::uint32_t> restore_command{next()};                ///< 1011h:01
  Slot<std::uint32_t> serial_number{next()};                  ///< 1018h:04
  Slot<std::uint8_t> save_parameters{next()};                 ///< P 11[1]
  Slot<std::uint8_t> factory_reset{next()};                   ///< P 11[3]
  Slot<std::uint32_t> input_state{next()};                    ///< P 121
  Slot<std::uint32_t> digital_inputs{next()};                 ///< 60FDh
  Slot<std::uint8_t> fault_reset_parameter{next()};           ///< P 153
  Slot<std::uint32_t> external_reaction_time{next()};         ///< P 154
  Slot<std::uint16_t> control_location{next()};               ///< P 159
  Slot<float> reference_cycle{next()};                        ///< P 306
  Slot<float> velocity_gain{next()};                          ///< P 320
  Slot<float> velocity_reset{next()};                         ///< P 321
  Slot<float> velocity_gain_scale{next()};                    ///< P 322
  Slot<float> velocity_filter{next()};                        ///< P 351
  Slot<float> position_gain{next()};                          ///< P 360
  Slot<std::uint8_t> interpolation_type{next()};              ///< P 370
  Slot<std::int16_t> interpolation_sub_mode{next()};          ///< 60C0h
  Slot<float> speed_feed_forward_scale{next()};               ///< P 375
  Slot<float> torque_feed_forward_scale{next()};              ///< P 376
  Slot<std::uint16_t> position_format{next()};                ///< P 379[0]
  Slot<std::uint16_t> speed_feed_forward_source{next()};      ///< P 379[1]
  Slot<std::uint16_t> torque_feed_forward_source{next()};     ///< P 379[2]
  Slot<float> standstill_window{next()};                      ///< P 745
  Slot<float> total_inertia{next()};                          ///< P 1516
  Slot<std::uint8_t> nmt_state{next()};                       ///< P 2060
  Slot<std::int16_t> quick_stop_option{next()};               ///< 605Ah
  Slot<std::int16_t> shutdown_option{next()};                 ///< 605Bh
  Slot<std::int16_t> disable_operation_option{next()};        ///< 605Ch
  Slot<std::int16_t> halt_option{next()};                     ///< 605Dh
  Slot<std::int16_t> fault_reaction_option{next()};           ///< 605Eh
  Slot<std::uint16_t> following_error_time{next()};           ///< 6066h
  Slot<std::int32_t> velocity_demand{next()};                 ///< 606Bh
  Slot<std::uint16_t> velocity_window{next()};                ///< 606Dh
  Slot<std::uint16_t> velocity_window_time{next()};           ///< 606Eh
  Slot<std::uint16_t> max_torque{next()};                     ///< 6072h
  Slot<std::int16_t> torque_demand{next()};                   ///< 6074h
  Slot<std::uint32_t> motor_rated_current{next()};            ///< 6075h
  Slot<std::uint32_t> motor_rated_torque{next()};             ///< 6076h
  Slot<std::int16_t> current_actual{next()};                  ///< 6078h
  Slot<std::uint32_t> dc_link_voltage{next()};                ///< 6079h
  Slot<std::int32_t> position_limit_min{next()};              ///< 607Dh:01
  Slot<std::int32_t> position_limit_max{next()};              ///< 607Dh:02
  Slot<std::uint8_t> polarity{next()};                        ///< 607Eh
  Slot<std::uint32_t> max_motor_speed{next()};                ///< 6080h
  Slot<std::uint32_t> profile_deceleration{next()};           ///< 6084h
  Slot<std::uint32_t> quick_stop_deceleration{next()};        ///< 6085h
  Slot<std::uint32_t> encoder_increments{next()};             ///< 608Fh:01
  Slot<std::uint32_t> encoder_revolutions{next()};            ///< 608Fh:02
  Slot<std::uint32_t> velocity_encoder_increments{next()};    ///< 6090h:01
  Slot<std::uint32_t> velocity_encoder_revolutions{next()};   ///< 6090h:02
  Slot<std::uint32_t> gear_motor_revolutions{next()};         ///< 6091h:01
  Slot<std::uint32_t> gear_shaft_revolutions{next()};         ///< 6091h:02
  Slot<std::uint32_t> feed{next()};                           ///< 6092h:01
  Slot<std::uint32_t> feed_revolutions{next()};               ///< 6092h:02
  Slot<std::uint32_t> position_factor_numerator{next()};      ///< 6093h:01
  Slot<std::uint32_t> position_factor_divisor{next()};        ///< 6093h:02
  Slot<std::uint32_t> velocity_factor_numerator{next()};      ///< 6094h:01
  Slot<std::uint32_t> velocity_factor_divisor{next()};        ///< 6094h:02
  Slot<std::uint32_t> acceleration_factor_numerator{next()};  ///< 6097h:01
  Slot<std::uint32_t> acceleration_factor_divisor{next()};    ///< 6097h:02
  Slot<std::uint8_t> interpolation_period_value{next()};      ///< 60C2h:01
  Slot<std::int8_t> interpolation_period_index{next()};       ///< 60C2h:02
  // profile position and profile velocity
  Slot<std::uint32_t> profile_velocity{next()};         ///< 6081h
  Slot<std::uint32_t> max_profile_velocity{next()};     ///< 607Fh
  Slot<std::uint32_t> profile_acceleration{next()};     ///< 6083h
  Slot<std::int16_t> motion_profile_type{next()};       ///< 6086h
  Slot<float> jerk_time{next()};                        ///< P 166
  Slot<std::uint16_t> velocity_threshold{next()};       ///< 606Fh
  Slot<std::uint16_t> velocity_threshold_time{next()};  ///< 6070h
  Slot<std::uint32_t> max_slippage{next()};             ///< 60F8h
  Slot<std::uint16_t> positioning_option{next()};       ///< 60F2h
  Slot<std::int32_t> range_min{next()};                 ///< 607Bh:01
  Slot<std::int32_t> range_max{next()};                 ///< 607Bh:02
  // homing
  Slot<std::int32_t> home_offset{next()};           ///< 607Ch
  Slot<std::int8_t> homing_method{next()};          ///< 6098h
  Slot<std::uint32_t> homing_speed_switch{next()};  ///< 6099h:01
  Slot<std::uint32_t> homing_speed_zero{next()};    ///< 6099h:02
  Slot<std::uint32_t> homing_acceleration{next()};  ///< 609Ah
  // velocity mode, interpolated position
  Slot<std::int16_t> velocity_setpoint{next()};               ///< 6042h
  Slot<std::uint32_t> velocity_min{next()};                   ///< 6046h:01
  Slot<std::uint32_t> velocity_max{next()};                   ///< 6046h:02
  Slot<std::uint32_t> velocity_acceleration_change{next()};   ///< 6048h:01
  Slot<std::uint32_t> velocity_acceleration_time{next()};     ///< 6048h:02
  Slot<std::uint32_t> velocity_deceleration_change{next()};   ///< 6049h:01
  Slot<std::uint32_t> velocity_deceleration_time{next()};     ///< 6049h:02
  Slot<std::int32_t> velocity_dimension_numerator{next()};    ///< 604Ch:01
  Slot<std::int32_t> velocity_dimension_denominator{next()};  ///< 604Ch:02
  // units
  Slot<std::int8_t> position_notation{next()};      ///< 6089h
  Slot<std::int8_t> velocity_notation{next()};      ///< 608Bh
  Slot<std::int8_t> acceleration_notation{next()};  ///< 608Dh
  // inputs and outputs
  SlotArray<std::uint16_t, 13> input_functions{next(13)};  ///< P 100-P 112, in order
  Slot<std::uint32_t> input_inversion{next()};             ///< P 120
  SlotArray<std::uint16_t, 5> output_functions{next(5)};   ///< P 122-P 126, in order
  Slot<std::uint32_t> output_state{next()};                ///< P 143
  Slot<std::uint32_t> output_mask{next()};                 ///< 60FEh:02
  Slot<float> brake_lift_time{next()};                     ///< P 213
  Slot<float> brake_close_time{next()};                    ///< P 214
  // touch probe
  Slot<std::uint16_t> touch_probe_variant{next()};         ///< P 2285
  Slot<std::uint16_t> touch_probe_status{next()};          ///< 60B9h
  SlotArray<std::int32_t, 4> touch_probe_values{next(4)};  ///< 60BAh-60BDh, in order
  // monitoring
  Slot<std::uint32_t> warnings{next()};                  ///< P 34
  Slot<std::uint16_t> overload_type{next()};             ///< P 735[0]
  Slot<float> overload_rated{next()};                    ///< P 733[0]
  Slot<float> overload_standstill{next()};               ///< P 733[1]
  Slot<float> overload_middle{next()};                   ///< P 733[2]
  Slot<float> overload_middle_frequency{next()};         ///< P 733[3]
  Slot<float> overload_rated_frequency{next()};          ///< P 733[4]
  Slot<float> overload_time_constant{next()};            ///< P 733[7]
  Slot<float> overload_integrator{next()};               ///< P 701[0]
  Slot<float> undervoltage_limit{next()};                ///< P 701[12]
  Slot<std::uint16_t> motor_temperature_sensor{next()};  ///< P 732[0]
  Slot<float> motor_temperature_max{next()};             ///< P 731[0]
  Slot<float> motor_temperature{next()};                 ///< P 701[1]
  Slot<float> dc_link_volts{next()};                     ///< P 410
  // actual values in motor units
  Slot<std::int32_t> actual_increments{next()};     ///< P 412
  Slot<std::int32_t> reference_increments{next()};  ///< P 413
  Slot<std::int32_t> increment_difference{next()};  ///< P 414
  Slot<float> actual_rpm{next()};                   ///< P 415
  Slot<float> reference_rpm{next()};                ///< P 416
  Slot<float> reference_torque_nm{next()};          ///< P 418
  Slot<float> actual_torque_nm{next()};             ///< P 419
  // motor data
  Slot<std::uint16_t> motor_type{next()};        ///< P 45
  Slot<float> motor_rated_frequency{next()};     ///< P 455
  Slot<float> motor_rated_current_a{next()};     ///< P 457
  Slot<float> motor_rated_torque_nm{next()};     ///< P 460
  Slot<float> motor_inertia{next()};             ///< P 461
  Slot<std::uint16_t> motor_pole_pairs{next()};  ///< P 463
  // U/f operation
  Slot<float> boost_voltage{next()};      ///< P 313
  Slot<float> nominal_frequency{next()};  ///< P 314
  Slot<float> nominal_voltage{next()};    ///< P 315
  // parameter service
  Slot<std::uint8_t> parameter_download{next()};  ///< P 11[4]
};

/// The slots of these values.
inline constexpr DriveValues kValue{};

}  // namespace driveline::slaves::msd
