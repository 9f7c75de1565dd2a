// Rows of the modes of operation: profile position and velocity, homing, velocity, interpolated position; units.
#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::string_view kProfile = "MSD manual 12.2; default ours";
constexpr std::string_view kHomingTable = "MSD manual Table 12.12; default ours";
constexpr std::string_view kVelocityTable = "MSD manual Tables 12.6, 12.7; default ours";
constexpr std::string_view kVelocityFactor = "CiA 402; velocity units of the factor group per unit of 6042h (ours)";
constexpr std::string_view kCiaOurs = "CiA 402; default ours";
constexpr std::string_view kUnits = "MSD manual Table 10.4; 10^index";
constexpr std::string_view kDimension = "MSD manual Table 10.4: indication only";
constexpr std::string_view kOptionAlias = "SERCOS manual Table 10.1: alias of 605Ah-605Eh";

/// Returns a row with the name of a unit.
constexpr EntryRow dimension(std::uint16_t index, std::string_view name) {
  return power_off(variable(index, esi::DataType::kUnsigned8, kStored, name, {}, {}, kDimension));
}
constexpr EntryRow notation(std::uint16_t index, Slot<std::int8_t> value, std::string_view name) {
  return power_off(variable(index, kStored, value, name, {0, -9, 9}, {}, kUnits));
}

constexpr std::array kModeRows = {
    variable(0x6042, kRx, kValue.velocity_setpoint, "vl target velocity", {}, "vel", "MSD manual Table 12.6"),
    array_length(0x6046, "vl velocity min max amount", 2, kVelocityTable),
    element(0x6046, 1, kStored, kValue.velocity_min, "vl velocity min amount", {}, "vel", kVelocityTable),
    element(0x6046, 2, kStored, kValue.velocity_max, "vl velocity max amount", {32767}, "vel", kVelocityTable),
    array_length(0x6048, "vl velocity acceleration", 2, kVelocityTable),
    element(0x6048, 1, kStored, kValue.velocity_acceleration_change, "Delta speed", {104857600, 1}, "vel",
            kVelocityTable),
    element(0x6048, 2, kStored, kValue.velocity_acceleration_time, "Delta time", {1, 1, 65535}, "s", kVelocityTable),
    array_length(0x6049, "vl velocity deceleration", 2, kVelocityTable),
    element(0x6049, 1, kStored, kValue.velocity_deceleration_change, "Delta speed", {104857600, 1}, "vel",
            kVelocityTable),
    element(0x6049, 2, kStored, kValue.velocity_deceleration_time, "Delta time", {1, 1, 65535}, "s", kVelocityTable),
    array_length(0x604C, "vl dimension factor", 2, kVelocityFactor),
    element(0x604C, 1, kStored, kValue.velocity_dimension_numerator, "vl dimension factor numerator",
            {1, 1, 2147483647}, {}, kVelocityFactor),
    element(0x604C, 2, kStored, kValue.velocity_dimension_denominator, "vl dimension factor denominator",
            {1, 1, 2147483647}, {}, kVelocityFactor),
    variable(0x606F, kStored, kValue.velocity_threshold, "Velocity threshold", {20000}, "vel", kCiaOurs),
    variable(0x6070, kStored, kValue.velocity_threshold_time, "Velocity threshold time", {1}, "ms", kCiaOurs),
    array_length(0x607B, "Position range limit", 2, "MSD manual Table 14.7"),
    element(0x607B, 1, kStored, kValue.range_min, "Min position range limit", {}, "pos",
            "MSD manual Table 14.7; order CiA 402; no limit unless min < max"),
    element(0x607B, 2, kStored, kValue.range_max, "Max position range limit", {}, "pos",
            "MSD manual Table 14.7; order CiA 402; no limit unless min < max"),
    variable(0x607C, kStored, kValue.home_offset, "Home offset", {}, "pos", "MSD manual 12.2.4"),
    variable(0x607F, kRxStored, kValue.max_profile_velocity, "Max profile velocity", {104857600}, "vel",
             "MSD manual Table 12.9; default ours: 6000 rpm"),
    variable(0x6081, kRxStored, kValue.profile_velocity, "Profile velocity", {10485760, 1}, "vel", kProfile),
    variable(0x6083, kRxStored, kValue.profile_acceleration, "Profile acceleration", {104857600, 1}, "acc", kProfile),
    variable(0x6086, kStored, kValue.motion_profile_type, "Motion profile type", {0, 0, 3}, {},
             "CiA 402: 0 linear, 3 jerk limited; Device Help: P 2243"),
    variable(0x6098, kRxStored, kValue.homing_method, "Homing method", {35, 0, 37}, {},
             "MSD manual Table 12.12; default ours"),
    array_length(0x6099, "Homing speeds", 2, kHomingTable),
    element(0x6099, 1, kRxStored, kValue.homing_speed_switch, "Speed during search for switch", {5242880, 1}, "vel",
            kHomingTable),
    element(0x6099, 2, kRxStored, kValue.homing_speed_zero, "Speed during search for zero", {524288, 1}, "vel",
            kHomingTable),
    variable(0x609A, kRxStored, kValue.homing_acceleration, "Homing acceleration", {104857600, 1}, "acc", kHomingTable),
    array_length(0x60C1, "Interpolation data record", 1, "MSD manual Table 12.15"),
    element(0x60C1, 1, kRx, kValue.interpolation_data, "Interpolation position", {}, "pos", "MSD manual Table 12.15"),
    variable(0x60F2, kRxStored, kValue.positioning_option, "Positioning option code", {}, {},
             "MSD manual Table 14.8: bits 6 and 7"),
    variable(0x60F8, kStored, kValue.max_slippage, "Max slippage", {0xFFFFFFFFU}, "vel",
             "MSD manual Table 12.11; object CiA 402; FFFFFFFFh: off (ours)"),
    notation(0x6089, kValue.position_notation, "Position notation index"),
    dimension(0x608A, "Position dimension index"),
    notation(0x608B, kValue.velocity_notation, "Velocity notation index"),
    dimension(0x608C, "Velocity dimension index"),
    notation(0x608D, kValue.acceleration_notation, "Acceleration notation index"),
    dimension(0x608E, "Acceleration dimension index"),
    variable(p(166), kStored, kValue.jerk_time, "MPRO_REF_JTIME", {0, 0, 10000}, "ms",
             "Device Help: smoothing time of the profile"),
    variable(p(2218), kStored, kValue.quick_stop_option, "MPRO_402_QuickStop_OC", {2, 0, 8}, {}, kOptionAlias),
    variable(p(2219), kStored, kValue.shutdown_option, "MPRO_402_ShutDown_OC", {0, -1, 1}, {}, kOptionAlias),
    variable(p(2220), kStored, kValue.disable_operation_option, "MPRO_402_DisableOp_OC", {1, 0, 1}, {}, kOptionAlias),
    variable(p(2221), kStored, kValue.halt_option, "MPRO_402_Halt_OC", {1, 0, 4}, {}, kOptionAlias),
    variable(p(2222), kStored, kValue.fault_reaction_option, "MPRO_402_FaultReaction_OC", {2, -2, 4}, {}, kOptionAlias),
    variable(p(2243), kStored, kValue.motion_profile_type, "MPRO_402_MotionProfType", {0, 0, 3}, {},
             "Device Help: alias of 6086h"),
    variable(p(2261), kStored, kValue.homing_method, "MPRO_402_HomingMethod", {35, 0, 37}, {},
             "SERCOS manual Table 10.1: alias of 6098h"),
};

}  // namespace

std::span<const EntryRow> mode_rows() {
  return kModeRows;
}

}  // namespace driveline::slaves::msd
