// Rows of the modes of operation: profile position and velocity, homing, velocity, interpolated position; units.
#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;

constexpr std::string_view kProfile = "MSD manual 12.2; default ours";
constexpr std::string_view kHomingTable = "MSD manual Table 12.12; default ours";
constexpr std::string_view kVelocityTable = "MSD manual Tables 12.6, 12.7; default ours";
constexpr std::string_view kVelocityFactor = "CiA 402; velocity units of the factor group per unit of 6042h (ours)";
constexpr std::string_view kCiaOurs = "CiA 402; default ours";
constexpr std::string_view kUnits = "MSD manual Table 10.4; 10^index";
constexpr std::string_view kDimension = "MSD manual Table 10.4: indication only";
constexpr std::string_view kOptionAlias = "SERCOS manual Table 10.1: alias of 605Ah-605Eh";
constexpr RowRange kPower{0, -9, 9};

/// An object of the factor group that may only be written with the power stage off.
constexpr EntryRow unit_index(std::uint16_t index, esi::DataType type, std::uint16_t slot, std::string_view name,
                              RowRange range, std::string_view source) {
  EntryRow row = variable(index, type, kStored, slot, name, range, {}, source);
  row.power_off_only = true;
  return row;
}

constexpr std::array kModeRows = {
    variable(0x6042, kInteger16, kRx, kVelocitySetpoint, "vl target velocity", {}, "vel", "MSD manual Table 12.6"),
    array_length(0x6046, "vl velocity min max amount", 2, kVelocityTable),
    element(0x6046, 1, kUnsigned32, kStored, kVelocityMin, "vl velocity min amount", {}, "vel", kVelocityTable),
    element(0x6046, 2, kUnsigned32, kStored, kVelocityMax, "vl velocity max amount", {32767}, "vel", kVelocityTable),
    array_length(0x6048, "vl velocity acceleration", 2, kVelocityTable),
    element(0x6048, 1, kUnsigned32, kStored, kVelocityAccelerationChange, "Delta speed", {104857600, 1}, "vel",
            kVelocityTable),
    element(0x6048, 2, kUnsigned32, kStored, kVelocityAccelerationTime, "Delta time", {1, 1, 65535}, "s",
            kVelocityTable),
    array_length(0x6049, "vl velocity deceleration", 2, kVelocityTable),
    element(0x6049, 1, kUnsigned32, kStored, kVelocityDecelerationChange, "Delta speed", {104857600, 1}, "vel",
            kVelocityTable),
    element(0x6049, 2, kUnsigned32, kStored, kVelocityDecelerationTime, "Delta time", {1, 1, 65535}, "s",
            kVelocityTable),
    array_length(0x604C, "vl dimension factor", 2, kVelocityFactor),
    element(0x604C, 1, kInteger32, kStored, kVelocityDimensionNumerator, "vl dimension factor numerator",
            {1, 1, 2147483647}, {}, kVelocityFactor),
    element(0x604C, 2, kInteger32, kStored, kVelocityDimensionDenominator, "vl dimension factor denominator",
            {1, 1, 2147483647}, {}, kVelocityFactor),
    variable(0x606F, kUnsigned16, kStored, kVelocityThreshold, "Velocity threshold", {20000}, "vel", kCiaOurs),
    variable(0x6070, kUnsigned16, kStored, kVelocityThresholdTime, "Velocity threshold time", {1}, "ms", kCiaOurs),
    array_length(0x607B, "Position range limit", 2, "MSD manual Table 14.7"),
    element(0x607B, 1, kInteger32, kStored, kRangeMin, "Min position range limit", {}, "pos",
            "MSD manual Table 14.7; order CiA 402; no limit unless min < max"),
    element(0x607B, 2, kInteger32, kStored, kRangeMax, "Max position range limit", {}, "pos",
            "MSD manual Table 14.7; order CiA 402; no limit unless min < max"),
    variable(0x607C, kInteger32, kStored, kHomeOffset, "Home offset", {}, "pos", "MSD manual 12.2.4"),
    variable(0x607F, kUnsigned32, kRxStored, kMaxProfileVelocity, "Max profile velocity", {104857600}, "vel",
             "MSD manual Table 12.9; default ours: 6000 rpm"),
    variable(0x6081, kUnsigned32, kRxStored, kProfileVelocity, "Profile velocity", {10485760, 1}, "vel", kProfile),
    variable(0x6083, kUnsigned32, kRxStored, kProfileAcceleration, "Profile acceleration", {104857600, 1}, "acc",
             kProfile),
    variable(0x6086, kInteger16, kStored, kMotionProfileType, "Motion profile type", {0, 0, 3}, {},
             "CiA 402: 0 linear, 3 jerk limited; Device Help: P 2243"),
    variable(0x6098, kInteger8, kRxStored, kHomingMethod, "Homing method", {35, 0, 37}, {},
             "MSD manual Table 12.12; default ours"),
    array_length(0x6099, "Homing speeds", 2, kHomingTable),
    element(0x6099, 1, kUnsigned32, kRxStored, kHomingSpeedSwitch, "Speed during search for switch", {5242880, 1},
            "vel", kHomingTable),
    element(0x6099, 2, kUnsigned32, kRxStored, kHomingSpeedZero, "Speed during search for zero", {524288, 1}, "vel",
            kHomingTable),
    variable(0x609A, kUnsigned32, kRxStored, kHomingAcceleration, "Homing acceleration", {104857600, 1}, "acc",
             kHomingTable),
    array_length(0x60C1, "Interpolation data record", 1, "MSD manual Table 12.15"),
    element(0x60C1, 1, kInteger32, kRx, kInterpolationData, "Interpolation position", {}, "pos",
            "MSD manual Table 12.15"),
    variable(0x60F2, kUnsigned16, kRxStored, kPositioningOption, "Positioning option code", {}, {},
             "MSD manual Table 14.8: bits 6 and 7"),
    variable(0x60F8, kUnsigned32, kStored, kMaxSlippage, "Max slippage", {0xFFFFFFFFU}, "vel",
             "MSD manual Table 12.11; object CiA 402; FFFFFFFFh: off (ours)"),
    unit_index(0x6089, kInteger8, kPositionNotation, "Position notation index", kPower, kUnits),
    unit_index(0x608A, kUnsigned8, slot::kOwn, "Position dimension index", {}, kDimension),
    unit_index(0x608B, kInteger8, kVelocityNotation, "Velocity notation index", kPower, kUnits),
    unit_index(0x608C, kUnsigned8, slot::kOwn, "Velocity dimension index", {}, kDimension),
    unit_index(0x608D, kInteger8, kAccelerationNotation, "Acceleration notation index", kPower, kUnits),
    unit_index(0x608E, kUnsigned8, slot::kOwn, "Acceleration dimension index", {}, kDimension),
    variable(p(166), kReal32, kStored, kJerkTime, "MPRO_REF_JTIME", {0, 0, 10000}, "ms",
             "Device Help: smoothing time of the profile"),
    variable(p(2218), kInteger16, kStored, kQuickStopOption, "MPRO_402_QuickStop_OC", {2, 0, 8}, {}, kOptionAlias),
    variable(p(2219), kInteger16, kStored, kShutdownOption, "MPRO_402_ShutDown_OC", {0, -1, 1}, {}, kOptionAlias),
    variable(p(2220), kInteger16, kStored, kDisableOperationOption, "MPRO_402_DisableOp_OC", {1, 0, 1}, {},
             kOptionAlias),
    variable(p(2221), kInteger16, kStored, kHaltOption, "MPRO_402_Halt_OC", {1, 0, 4}, {}, kOptionAlias),
    variable(p(2222), kInteger16, kStored, kFaultReactionOption, "MPRO_402_FaultReaction_OC", {2, -2, 4}, {},
             kOptionAlias),
    variable(p(2243), kInteger16, kStored, kMotionProfileType, "MPRO_402_MotionProfType", {0, 0, 3}, {},
             "Device Help: alias of 6086h"),
    variable(p(2261), kInteger8, kStored, kHomingMethod, "MPRO_402_HomingMethod", {35, 0, 37}, {},
             "SERCOS manual Table 10.1: alias of 6098h"),
};

}  // namespace

std::span<const EntryRow> mode_rows() {
  return kModeRows;
}

}  // namespace driveline::slaves::msd
