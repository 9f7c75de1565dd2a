// Rows of the objects of CiA 402 that every mode uses.
#include <array>

#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;
using esi::ObjectCode;

constexpr std::string_view kCia = "CiA 402 (IEC 61800-7-201)";
constexpr std::string_view kScaling = "MSD manual 10.3; default ours: increments of the motor encoder";

/// Returns the numerator (sub 1) or divisor (sub 2) of a fraction of the factor group.
constexpr EntryRow fraction(std::uint16_t index, std::uint8_t subindex, Slot<std::uint32_t> value,
                            std::string_view name, double initial) {
  return power_off(element(index, subindex, kStored, value, name, {initial, 1}, {}, kScaling));
}
constexpr EntryRow factor(std::uint16_t index, std::uint8_t subindex, Slot<std::uint32_t> value,
                          std::string_view name) {
  return element(index, subindex, access::kRead, value, name, {1}, {}, "MSD manual 10.3.2: calculated by the drive");
}

constexpr std::array kStateRows = {
    variable(0x603F, kTx, kValue.error_code, "Error code", {}, {}, kCia),
    variable(0x6040, kRx, kValue.control_word, "Control word", {}, {}, "MSD manual 11.3.1"),
    variable(0x6041, kTx, kValue.status_word, "Status word", {}, {}, "MSD manual 11.3.2"),
    variable(0x605A, kStored, kValue.quick_stop_option, "Quick stop option code", {2, 0, 8}, {},
             "MSD manual Table 10.3; default CiA 402"),
    variable(0x605B, kStored, kValue.shutdown_option, "Shutdown option code", {0, -1, 1}, {},
             "MSD manual Table 10.3; default CiA 402"),
    variable(0x605C, kStored, kValue.disable_operation_option, "Disable operation option code", {1, 0, 1}, {},
             "MSD manual Table 10.3; default CiA 402"),
    variable(0x605D, kStored, kValue.halt_option, "Halt option code", {1, 0, 4}, {},
             "MSD manual Table 10.3; default CiA 402; modes 8, 9, 10 have no halt"),
    variable(0x605E, kStored, kValue.fault_reaction_option, "Fault reaction option code", {2, -2, 4}, {},
             "MSD manual Table 10.3; default CiA 402"),
    variable(0x6060, kRx, kValue.mode, "Modes of operation", {}, {}, "MSD manual 12.1; not stored (7.5.3)"),
    variable(0x6061, kTx, kValue.mode_display, "Modes of operation display", {}, {}, "MSD manual 12.1"),
    constant(0x6502, 0, ObjectCode::kVariable, kUnsigned32, "Supported drive modes", 0x03E7,
             "MSD manual 6.4.1; bits CiA 402: modes 1, 2, 3, 6, 7, 8, 9, 10"),
};

constexpr std::array kPositionRows = {
    variable(0x6062, kTx, kValue.position_demand, "Position demand value", {}, "inc", kCia),
    variable(0x6064, kTx, kValue.position_actual, "Position actual value", {}, "inc", "MSD manual 12.2.1"),
    variable(0x6065, kStored, kValue.following_error_window, "Following error window", {1048576}, "inc",
             "CiA 402; FFFFFFFFh: off; default ours: one revolution"),
    variable(0x6066, kStored, kValue.following_error_time, "Following error time out", {10}, "ms",
             "CiA 402; default ours"),
    variable(0x6067, kStored, kValue.position_window, "Position window", {1000}, "inc",
             "CiA 402; FFFFFFFFh: off; default ours"),
    variable(0x6068, kStored, kValue.position_window_time, "Position window time", {1}, "ms", "CiA 402; default ours"),
    variable(0x607A, kRx, kValue.target_position, "Target position", {}, "inc", "MSD manual Table 12.19"),
    array_length(0x607D, "Software position limit", 2, "MSD manual 12.2.1"),
    element(0x607D, 1, kStored, kValue.position_limit_min, "Min position limit", {}, "inc",
            "CiA 402; no limit unless min < max"),
    element(0x607D, 2, kStored, kValue.position_limit_max, "Max position limit", {}, "inc",
            "CiA 402; no limit unless min < max"),
    variable(0x6084, kStored, kValue.profile_deceleration, "Profile deceleration", {104857600, 1}, "inc/s2",
             "MSD manual 12.2.1; default ours"),
    variable(0x6085, kStored, kValue.quick_stop_deceleration, "Quick stop deceleration", {419430400, 1}, "inc/s2",
             "MSD manual 12.2.1; default ours"),
    variable(0x60C0, kStored, kValue.interpolation_sub_mode, "Interpolation sub mode select", {0, -5, 0}, {},
             "MSD manual Table 12.16: the same setting as P 370"),
    record_length(0x60C2, 0x0080, "Interpolation time period", 2, kCia),
    field(0x60C2, 1, kStored, kValue.interpolation_period_value, "Interpolation time period value", {1, 1}, {},
          "MSD manual 7.4.2; default CiA 402: 1 ms"),
    field(0x60C2, 2, kStored, kValue.interpolation_period_index, "Interpolation time index", {-3, -6, 0}, {},
          "MSD manual 7.4.2; default CiA 402: 1 ms"),
    variable(0x60F4, kTx, kValue.following_error, "Following error actual value", {}, "inc", kCia),
};

constexpr std::array kVelocityRows = {
    variable(0x606B, kTx, kValue.velocity_demand, "Velocity demand value", {}, "inc/s", kCia),
    variable(0x606C, kTx, kValue.velocity_actual, "Velocity actual value", {}, "inc/s", "MSD manual 12.2.3"),
    variable(0x606D, kStored, kValue.velocity_window, "Velocity window", {20000}, "inc/s", "CiA 402; default ours"),
    variable(0x606E, kStored, kValue.velocity_window_time, "Velocity window time", {1}, "ms", "CiA 402; default ours"),
    variable(0x6080, kStored, kValue.max_motor_speed, "Max motor speed", {6000, kNoMinimum, 1000000}, "rpm",
             "CiA 402; default ours"),
    variable(0x60B1, kRx, kValue.velocity_offset, "Velocity offset", {}, "inc/s", "MSD manual 12.4"),
    variable(0x60FF, kRx, kValue.target_velocity, "Target velocity", {}, "inc/s", "MSD manual Table 12.21"),
};

constexpr std::array kTorqueRows = {
    variable(0x6071, kRx, kValue.target_torque, "Target torque", {}, "0.1 %", "MSD manual Table 12.23"),
    variable(0x6072, kRxStored, kValue.max_torque, "Max torque", {3000}, "0.1 %", "CiA 402; default ours"),
    variable(0x6074, kTx, kValue.torque_demand, "Torque demand value", {}, "0.1 %", kCia),
    variable(0x6075, access::kRead, kValue.motor_rated_current, "Motor rated current", {}, "mA", kCia),
    variable(0x6076, access::kRead, kValue.motor_rated_torque, "Motor rated torque", {}, "mNm",
             "MSD manual 12.4; unit CiA 402"),
    variable(0x6077, kTx, kValue.torque_actual, "Torque actual value", {}, "0.1 %", kCia),
    variable(0x6078, kTx, kValue.current_actual, "Current actual value", {}, "0.1 %", kCia),
    variable(0x6079, kTx, kValue.dc_link_voltage, "DC link circuit voltage", {}, "mV", kCia),
    variable(0x60B2, kRx, kValue.torque_offset, "Torque offset", {}, "0.1 %",
             "MSD manual Table 12.25: 1000 = rated torque"),
    variable(0x60FD, kTx, kValue.digital_inputs, "Digital inputs", {}, {}, "MSD manual Table 10.5: bits 18 and 19"),
};

constexpr std::array kScalingRows = {
    power_off(variable(0x607E, kStored, kValue.polarity, "Polarity", {}, {},
                       "MSD manual 10.3.2: bit 7 position, bit 6 velocity")),
    array_length(0x608F, "Position encoder resolution", 2, kScaling),
    fraction(0x608F, 1, kValue.encoder_increments, "Encoder increments", 1 << 20),
    fraction(0x608F, 2, kValue.encoder_revolutions, "Motor revolutions", 1),
    array_length(0x6090, "Velocity encoder resolution", 2, kScaling),
    fraction(0x6090, 1, kValue.velocity_encoder_increments, "Encoder increments per second", 1 << 20),
    fraction(0x6090, 2, kValue.velocity_encoder_revolutions, "Motor revolutions per second", 1),
    array_length(0x6091, "Gear ratio", 2, kScaling),
    fraction(0x6091, 1, kValue.gear_motor_revolutions, "Motor shaft revolutions", 1),
    fraction(0x6091, 2, kValue.gear_shaft_revolutions, "Drive shaft revolutions", 1),
    array_length(0x6092, "Feed constant", 2, kScaling),
    fraction(0x6092, 1, kValue.feed, "Feed", 1 << 20),
    fraction(0x6092, 2, kValue.feed_revolutions, "Drive shaft revolutions", 1),
    array_length(0x6093, "Position factor", 2, kScaling),
    factor(0x6093, 1, kValue.position_factor_numerator, "Numerator"),
    factor(0x6093, 2, kValue.position_factor_divisor, "Divisor"),
    array_length(0x6094, "Velocity encoder factor", 2, kScaling),
    factor(0x6094, 1, kValue.velocity_factor_numerator, "Numerator"),
    factor(0x6094, 2, kValue.velocity_factor_divisor, "Divisor"),
    array_length(0x6097, "Acceleration factor", 2, kScaling),
    factor(0x6097, 1, kValue.acceleration_factor_numerator, "Numerator"),
    factor(0x6097, 2, kValue.acceleration_factor_divisor, "Divisor"),
};

std::vector<EntryRow> make_profile_rows() {
  std::vector<EntryRow> rows;
  for (const std::span<const EntryRow> part :
       {std::span<const EntryRow>(kStateRows), std::span<const EntryRow>(kPositionRows),
        std::span<const EntryRow>(kVelocityRows), std::span<const EntryRow>(kTorqueRows),
        std::span<const EntryRow>(kScalingRows)}) {
    rows.insert(rows.end(), part.begin(), part.end());
  }
  return rows;
}

}  // namespace

std::span<const EntryRow> profile_rows() {
  static const std::vector<EntryRow> kRows = make_profile_rows();
  return kRows;
}

}  // namespace driveline::slaves::msd
