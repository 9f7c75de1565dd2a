// Rows of the values that only the profile SERCOS has. Lines are those of "ServoOne User Manual SERCOS II interface",
// 1100.29B.2-00; defaults are ours where the text has none, in the preferred rotary weighting (0.0001 degrees,
// 0.0001 rpm, 0.001 rad/s2, 0.1 % of P 460).
#include <array>

#include "driveline/slaves/msd/core/sercos/sercos_values.hpp"
#include "msd/core/table_row.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kFirstStandard = 10000;  ///< parameter 10000 + n is S-0-n (lines 392-394)

constexpr std::uint16_t s(std::uint16_t number) {
  return p(static_cast<std::uint16_t>(kFirstStandard + number));
}

constexpr std::array kStandardRows = {
    variable(s(1), kStored, kSercosValue.control_cycle, "Control unit cycle time", {1000, 125, 65000}, "us",
             "line 1526; limits lines 177, 187"),
    variable(s(11), kTx, kSercosValue.classes[0], "Class 1 diagnostic", {}, {}, "line 753"),
    variable(s(12), kTx, kSercosValue.classes[1], "Class 2 diagnostic", {}, {}, "line 764"),
    variable(s(13), kTx, kSercosValue.classes[2], "Class 3 diagnostic", {}, {}, "line 775"),
    variable(s(14), kTx, kSercosValue.interface_status, "Interface status", {}, {}, "line 790"),
    variable(s(32), kStored, kSercosValue.modes[0], "Primary operation mode", {0x000B}, {}, "line 1560"),
    variable(s(33), kStored, kSercosValue.modes[1], "Secondary operation mode 1", {}, {}, "line 1561"),
    variable(s(34), kStored, kSercosValue.modes[2], "Secondary operation mode 2", {}, {}, "line 1562"),
    variable(s(35), kStored, kSercosValue.modes[3], "Secondary operation mode 3", {}, {}, "line 1563"),
    variable(s(36), kRx, kSercosValue.velocity_command, "Velocity command value", {}, "SPEED", "line 931"),
    variable(s(37), kRx, kSercosValue.additive_velocity, "Additive velocity command value", {}, "SPEED", "line 931"),
    variable(s(38), kStored, kSercosValue.positive_velocity_limit, "Positive velocity limit", {6e7}, "SPEED",
             "line 1566"),
    variable(s(39), kStored, kSercosValue.negative_velocity_limit, "Negative velocity limit", {-6e7}, "SPEED",
             "line 1567"),
    variable(s(47), kRx, kSercosValue.position_command, "Position command value", {}, "POS", "line 1575"),
    variable(s(57), kStored, kSercosValue.position_window, "Position window", {1e4}, "POS", "line 1588"),
    variable(s(80), kRx, kSercosValue.torque_command, "Torque command value", {}, "TORQUE", "line 915"),
    variable(s(81), kRx, kSercosValue.additive_torque, "Additive torque command value", {}, "TORQUE", "line 916"),
    variable(s(82), kStored, kSercosValue.positive_torque_limit, "Positive torque limit", {3000}, "TORQUE",
             "line 1595"),
    variable(s(83), kStored, kSercosValue.negative_torque_limit, "Negative torque limit", {-3000}, "TORQUE",
             "line 1596"),
    variable(s(84), kTx, kSercosValue.torque_feedback, "Torque feedback value", {}, "TORQUE", "line 917"),
    variable(s(91), kStored, kSercosValue.velocity_limit, "Bipolar velocity limit", {6e7}, "SPEED", "line 1604"),
    variable(s(92), kStored, kSercosValue.torque_limit, "Bipolar torque limit", {3000}, "TORQUE", "line 1605"),
    variable(s(97), kStored, kSercosValue.class_masks[0], "Mask class 2 diagnostic", {}, {}, "line 764"),
    variable(s(98), kStored, kSercosValue.class_masks[1], "Mask class 3 diagnostic", {}, {}, "line 775"),
    variable(s(99), access::kReadWrite, kSercosValue.reset_class_1, "Reset class 1 diagnostic", {0, 0, 3}, {},
             "line 648"),
    variable(s(108), kRxStored, kSercosValue.feed_rate_override, "Feedrate override", {10000, 0, 25500}, "0.01 %",
             "line 1624"),
    variable(s(124), kStored, kSercosValue.standstill_window, "Standstill window", {1e5}, "SPEED", "line 1635"),
    variable(s(125), kStored, kSercosValue.velocity_threshold, "Velocity threshold", {1e5}, "SPEED", "line 1636"),
    variable(s(126), kStored, kSercosValue.torque_threshold, "Torque threshold", {100}, "TORQUE", "line 1637"),
    variable(s(134), kRx, kSercosValue.control_word, "Master control word", {}, {}, "Table 4.1"),
    variable(s(135), kTx, kSercosValue.status_word, "Drive status word", {}, {}, "Table 4.2"),
    variable(s(144), kTx, kSercosValue.signal_status, "Signal status word", {}, {}, "line 733"),
    variable(s(145), kRx, kSercosValue.signal_control, "Signal control word", {}, {}, "line 722"),
    variable(s(157), kStored, kSercosValue.velocity_window, "Velocity window", {1e5}, "SPEED", "line 1664"),
    variable(s(159), kStored, kSercosValue.monitored_difference, "Monitoring window", {3.6e6}, "POS", "line 754"),
    variable(s(258), kRx, kSercosValue.target_position, "Target position", {}, "POS", "line 973"),
    variable(s(259), kRxStored, kSercosValue.positioning_velocity, "Positioning velocity", {1e7}, "SPEED", "line 973"),
    variable(s(260), kRxStored, kSercosValue.positioning_acceleration, "Positioning acceleration", {1e6}, "ACC",
             "line 973"),
    variable(s(282), kRx, kSercosValue.positioning_command, "Positioning command value", {}, "POS", "line 975"),
    variable(s(300), kTx, kSercosValue.control_bits[0], "Real-time control bit 1", {}, {}, "line 445"),
    variable(s(301), kStored, kSercosValue.control_bit_targets[0], "Allocation of control bit 1", {}, {}, "line 656"),
    variable(s(302), kTx, kSercosValue.control_bits[1], "Real-time control bit 2", {}, {}, "line 444"),
    variable(s(303), kStored, kSercosValue.control_bit_targets[1], "Allocation of control bit 2", {}, {}, "line 658"),
    variable(s(304), kTx, kSercosValue.status_bits[0], "Real-time status bit 1", {}, {}, "line 572"),
    variable(s(305), kStored, kSercosValue.status_bit_sources[0], "Allocation of status bit 1", {}, {}, "line 660"),
    variable(s(306), kTx, kSercosValue.status_bits[1], "Real-time status bit 2", {}, {}, "line 571"),
    variable(s(307), kStored, kSercosValue.status_bit_sources[1], "Allocation of status bit 2", {}, {}, "line 662"),
    variable(s(336), kTx, kSercosValue.in_position, "In position", {}, {}, "line 776"),
    variable(s(346), kRx, kSercosValue.positioning_control, "Positioning control word", {}, {}, "lines 995-1006"),
    variable(s(359), kRxStored, kSercosValue.positioning_deceleration, "Positioning deceleration", {}, "ACC",
             "line 1735; 0: S-0-0260"),
    variable(s(393), kStored, kSercosValue.positioning_mode, "Command value mode", {}, {}, "lines 1012-1021"),
    variable(s(413), kStored, kSercosValue.control_bit_numbers[0], "Bit number of control bit 1", {0, 0, 31}, {},
             "line 657"),
    variable(s(414), kStored, kSercosValue.control_bit_numbers[1], "Bit number of control bit 2", {0, 0, 31}, {},
             "line 659"),
    variable(s(415), kStored, kSercosValue.status_bit_numbers[0], "Bit number of status bit 1", {0, 0, 31}, {},
             "line 661"),
    variable(s(416), kStored, kSercosValue.status_bit_numbers[1], "Bit number of status bit 2", {0, 0, 31}, {},
             "line 663"),
    variable(s(417), kStored, kSercosValue.short_way_velocity, "Positioning velocity threshold in modulo mode", {},
             "SPEED", "line 1769"),
    variable(s(418), kStored, kSercosValue.short_way_window, "Target position window in modulo mode", {}, "POS",
             "line 1770"),
    variable(s(419), kTx, kSercosValue.setpoint_acknowledge, "Positioning acknowledge", {}, {}, "line 1008"),
    variable(s(430), kTx, kSercosValue.active_target, "Active target position", {}, "POS", "line 1772"),
};

/// Returns the row of a share in percent; 100 is no limit of its own.
constexpr EntryRow share(std::uint16_t number, Slot<float> value, std::string_view name, std::string_view source) {
  return variable(p(number), kStored, value, name, {100, 0, 1000}, "%", source);
}

constexpr std::array kProductRows = {
    variable(p(144), kStored, kSercosValue.level_control, "Auto start of system", {0, 0, 1}, {}, "line 486"),
    variable(p(156), kStored, kSercosValue.enable_option, "Enable operation option code", {0, 0, 1}, {}, "line 507"),
    share(167, kSercosValue.speed_override, "Speed override factor", "line 937"),
    element(p(168), 0, kStored, kSercosValue.jog_speeds[0], "Fast jogging speed", {}, "SPEED", "line 520"),
    element(p(168), 1, kStored, kSercosValue.jog_speeds[1], "Slow jogging speed", {}, "SPEED", "line 520"),
    share(328, kSercosValue.speed_share, "Speed limit", "line 942"),
    variable(p(329), kStored, kSercosValue.torque_share, "Torque limit", {300, 0, 1000}, "%", "line 926"),
    share(330, kSercosValue.negative_torque_share, "Negative torque limit", "line 926"),
    share(331, kSercosValue.positive_torque_share, "Positive torque limit", "line 927"),
    share(332, kSercosValue.online_torque_share, "Online torque limit", "line 926"),
    share(333, kSercosValue.negative_speed_share, "Negative speed limit", "line 943"),
    share(334, kSercosValue.positive_speed_share, "Positive speed limit", "line 944"),
    variable(p(377), kTx, kSercosValue.feed_forward_shown, "Feed-forward signals enabled", {}, {}, "line 1048"),
    variable(p(458), kStored, kSercosValue.rated_speed, "Motor rated speed", {3000, 0, 1e6}, "rpm", "line 941"),
    variable(p(522), kStored, kSercosValue.position_encoder, "Encoder of the position control", {1, 1, 3}, {},
             "line 884"),
    variable(p(530), kStored, kSercosValue.encoder_channels[0], "Channel of position encoder 1", {1, 0, 3}, {},
             "line 882"),
    variable(p(531), kStored, kSercosValue.encoder_channels[1], "Channel of position encoder 2", {0, 0, 3}, {},
             "line 882"),
    variable(p(743), kStored, kSercosValue.tracking_limit, "Maximum tracking error", {}, "POS", "lines 509-514"),
    variable(p(2242), kStored, kSercosValue.quick_stop_acceleration, "Quick stop deceleration", {1e6, 1}, "ACC",
             "line 431"),
    variable(p(3005), kStored, kSercosValue.speed_acceleration, "Speed acceleration", {}, "ACC",
             "line 938; 0: P 2242 (ours)"),
    variable(p(3006), kStored, kSercosValue.speed_deceleration, "Speed deceleration", {}, "ACC",
             "line 939; 0: P 2242 (ours)"),
    variable(p(3054), kStored, kSercosValue.feed_forward_gain, "Gain of external feed-forward", {1, 0, 1e6}, {},
             "line 1068"),
    variable(p(3055), kRx, kSercosValue.velocity_feed_forward, "External speed feed-forward", {}, "SPEED", "line 1026"),
    variable(p(3056), kRx, kSercosValue.acceleration_feed_forward, "External acceleration feed-forward", {}, "ACC",
             "line 1027"),
    variable(p(3100), kRx, kSercosValue.position_fraction, "Fraction of the position command", {}, {}, "line 899"),
};

struct Default {
  std::uint16_t slot;
  double initial;
};
/// Defaults that the profile changes: lines 484 and 485 of the manual; IDN 370 of the ServoOne.
constexpr std::array kDefaults = {
    Default{kValue.control_location.number, 6}, Default{kValue.reference_source.number, 8},
    Default{kValue.interpolation_type.number, 3}, Default{kValue.interpolation_sub_mode.number, -3}};

}  // namespace

std::vector<EntryRow> sercos_drive_rows(Variant variant) {
  std::vector<EntryRow> rows = drive_rows(variant);
  for (auto& row : rows) {
    for (const auto& [slot, initial] : kDefaults) {
      if (row.slot == slot && !is_string(row.type)) row.initial = initial;
    }
  }
  rows.insert(rows.end(), kStandardRows.begin(), kStandardRows.end());
  rows.insert(rows.end(), kProductRows.begin(), kProductRows.end());
  return rows;
}

}  // namespace driveline::slaves::msd
