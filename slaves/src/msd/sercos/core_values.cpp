#include "driveline/slaves/msd/sercos/core_values.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "idn_table_row.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

constexpr std::string_view kSameNumber = "SERCOS manual 398: the P parameter of this number is 2000h + number";
constexpr std::string_view kWeightedObject = "meaning of the object in CiA 402, in units of the weighting; ours";
constexpr std::string_view kOneGain = "SERCOS manual 947-955, 1042-1053: alternatives of one value; factor ours";
constexpr bool kOwnDefault = true;

constexpr std::uint16_t object(std::uint16_t parameter) {
  return static_cast<std::uint16_t>(0x2000 + parameter);
}

/// Returns a value whose numbers differ by a factor at most.
template <typename T>
constexpr CoreValue value(std::uint16_t idn, std::uint16_t index, std::uint8_t subindex, Slot<T> slot,
                          std::string_view source) {
  return {.idn = {idn},
          .index = index,
          .subindex = subindex,
          .slot = slot.number,
          .type = data_type<T>(),
          .source = source};
}
/// Returns a P parameter that has the same number in the core.
template <typename T>
constexpr CoreValue parameter(std::uint16_t number, Slot<T> slot, bool own_default = false) {
  CoreValue row = value(p_raw(number), object(number), 0, slot, kSameNumber);
  row.own_default = own_default;
  return row;
}
constexpr CoreValue converted(CoreConversion conversion, CoreValue row) {
  row.conversion = conversion;
  return row;
}
constexpr CoreValue scaled(double factor, CoreValue row) {
  row.factor = factor;
  return row;
}
constexpr CoreValue turned_by(Polarity polarity, CoreValue row) {
  row.polarity = polarity;
  return row;
}
/// The object's own default has another unit.
constexpr CoreValue with_default(CoreValue row) {
  row.own_default = true;
  return row;
}

constexpr std::array kStandardValues = {
    turned_by(Polarity::kSpeedSetpoint, value(36, 0x60FF, 0, kValue.target_velocity, kWeightedObject)),
    turned_by(Polarity::kSpeedAdditive, value(37, 0x60B1, 0, kValue.velocity_offset, kWeightedObject)),
    turned_by(Polarity::kSpeed1, value(40, 0x606C, 0, kValue.velocity_actual, kWeightedObject)),
    with_default(value(41, 0x6099, 1, kValue.homing_speed_switch, "SERCOS manual 1408, 1418; CiA 402")),
    with_default(value(42, 0x609A, 0, kValue.homing_acceleration, "SERCOS manual 1408; CiA 402")),
    turned_by(Polarity::kPositionSetpoint, value(47, 0x607A, 0, kValue.target_position, kWeightedObject)),
    turned_by(Polarity::kPosition1, value(51, 0x6064, 0, kValue.position_actual, kWeightedObject)),
    with_default(value(57, 0x6067, 0, kValue.position_window, "its name; CiA 402")),
    turned_by(Polarity::kTorqueSetpoint,
              converted(CoreConversion::kTorque, value(80, 0x6071, 0, kValue.target_torque, kWeightedObject))),
    turned_by(Polarity::kTorqueAdditive,
              converted(CoreConversion::kTorque, value(81, 0x60B2, 0, kValue.torque_offset, kWeightedObject))),
    turned_by(Polarity::kTorque,
              converted(CoreConversion::kTorque, value(84, 0x6077, 0, kValue.torque_actual, kWeightedObject))),
    with_default(converted(CoreConversion::kTorque, value(92, 0x6072, 0, kValue.max_torque, kWeightedObject))),
    scaled(1e-4, value(100, object(320), 0, kValue.velocity_gain, kOneGain)),
    scaled(0.1, value(101, object(321), 0, kValue.velocity_reset, kOneGain)),
    scaled(10.0, value(104, object(360), 0, kValue.position_gain, kOneGain)),
    value(113, 0x6080, 0, kValue.max_motor_speed, "its name; CiA 402"),
    with_default(converted(CoreConversion::kSpeedRpm, value(124, object(745), 0, kValue.standstill_window,
                                                            "SERCOS manual 775: n = 0; MSD manual Table 12.20"))),
    turned_by(Polarity::kPosition1, value(130, 0x60BA, 0, kValue.touch_probe_values[0], kWeightedObject)),
    turned_by(Polarity::kPosition1, value(131, 0x60BB, 0, kValue.touch_probe_values[1], kWeightedObject)),
    turned_by(Polarity::kPosition1, value(132, 0x60BC, 0, kValue.touch_probe_values[2], kWeightedObject)),
    turned_by(Polarity::kPosition1, value(133, 0x60BD, 0, kValue.touch_probe_values[3], kWeightedObject)),
    with_default(value(159, 0x6065, 0, kValue.following_error_window, "SERCOS manual 754; CiA 402")),
    turned_by(Polarity::kPosition1, value(189, 0x60F4, 0, kValue.following_error, "SERCOS manual 1050; sign ours")),
    with_default(value(259, 0x6081, 0, kValue.profile_velocity, "SERCOS manual 973; CiA 402")),
    with_default(value(260, 0x6083, 0, kValue.profile_acceleration, "SERCOS manual 973; CiA 402")),
    scaled(0.1, value(296, object(375), 0, kValue.speed_feed_forward_scale, kOneGain)),
    scaled(0.1, value(348, object(376), 0, kValue.torque_feed_forward_scale, kOneGain)),
    value(380, object(410), 0, kValue.dc_link_volts, "its name"),
    scaled(0.1, value(383, object(701), 1, kValue.motor_temperature, "its name")),
    converted(CoreConversion::kRatedCurrent,
              scaled(0.1, value(389, 0x6078, 0, kValue.current_actual, "its name; CiA 402"))),
};

constexpr std::array kProductValues = {
    CoreValue{.idn = {p_raw(3)}, .index = object(3), .conversion = CoreConversion::kText, .source = kSameNumber},
    parameter(34, kValue.warnings),
    parameter(100, kValue.input_functions[0]),
    parameter(101, kValue.input_functions[1]),
    parameter(102, kValue.input_functions[2]),
    parameter(103, kValue.input_functions[3]),
    parameter(104, kValue.input_functions[4]),
    parameter(105, kValue.input_functions[5]),
    parameter(106, kValue.input_functions[6]),
    parameter(107, kValue.input_functions[7]),
    parameter(108, kValue.input_functions[8]),
    parameter(109, kValue.input_functions[9]),
    parameter(110, kValue.input_functions[10]),
    parameter(120, kValue.input_inversion),
    parameter(121, kValue.input_state),
    parameter(122, kValue.output_functions[0]),
    parameter(123, kValue.output_functions[1]),
    parameter(124, kValue.output_functions[2]),
    parameter(125, kValue.output_functions[3]),
    parameter(126, kValue.output_functions[4]),
    parameter(143, kValue.output_state),
    parameter(153, kValue.fault_reset_parameter),
    parameter(154, kValue.external_reaction_time),
    parameter(159, kValue.control_location, kOwnDefault),
    parameter(165, kValue.reference_source, kOwnDefault),
    parameter(166, kValue.jerk_time),
    parameter(213, kValue.brake_lift_time),
    parameter(214, kValue.brake_close_time),
    turned_by(Polarity::kPosition1,
              value(p_raw(279), 0x60F4, 0, kValue.following_error, "SERCOS manual 1050; sign ours")),
    parameter(306, kValue.reference_cycle),
    parameter(313, kValue.boost_voltage),
    parameter(314, kValue.nominal_frequency),
    parameter(315, kValue.nominal_voltage),
    parameter(320, kValue.velocity_gain),
    parameter(321, kValue.velocity_reset),
    parameter(322, kValue.velocity_gain_scale),
    parameter(351, kValue.velocity_filter),
    parameter(360, kValue.position_gain),
    parameter(370, kValue.interpolation_type, kOwnDefault),
    parameter(375, kValue.speed_feed_forward_scale),
    parameter(376, kValue.torque_feed_forward_scale),
    parameter(379, kValue.position_format),
    parameter(410, kValue.dc_link_volts),
    parameter(412, kValue.actual_increments),
    parameter(413, kValue.reference_increments),
    parameter(414, kValue.increment_difference),
    parameter(415, kValue.actual_rpm),
    parameter(416, kValue.reference_rpm),
    parameter(418, kValue.reference_torque_nm),
    parameter(419, kValue.actual_torque_nm),
    value(p_raw(450), object(45), 0, kValue.motor_type, "its name; MSD manual 8.2.2"),
    parameter(455, kValue.motor_rated_frequency),
    parameter(457, kValue.motor_rated_current_a),
    parameter(460, kValue.motor_rated_torque_nm),
    parameter(461, kValue.motor_inertia),
    parameter(463, kValue.motor_pole_pairs),
    parameter(1516, kValue.total_inertia),
    parameter(2218, kValue.quick_stop_option),
    parameter(2219, kValue.shutdown_option),
    parameter(2220, kValue.disable_operation_option),
    parameter(2221, kValue.halt_option),
    parameter(2222, kValue.fault_reaction_option),
    with_default(value(p_raw(2242), 0x6085, 0, kValue.quick_stop_deceleration, "SERCOS manual 431; CiA 402")),
    parameter(2261, kValue.homing_method),
    value(p_raw(3007), object(701), 0, kValue.overload_integrator, "its name; Device Help: P 701[0]"),
    with_default(value(p_raw(3031), 0x6099, 2, kValue.homing_speed_zero, "SERCOS manual 1408, 1422; CiA 402")),
};

constexpr auto kCoreValues = [] {
  std::array<CoreValue, kStandardValues.size() + kProductValues.size()> all{};
  std::copy(kStandardValues.begin(), kStandardValues.end(), all.begin());
  std::copy(kProductValues.begin(), kProductValues.end(), all.begin() + kStandardValues.size());
  return all;
}();
static_assert(std::is_sorted(kCoreValues.begin(), kCoreValues.end(),
                             [](const auto& a, const auto& b) { return a.idn.raw <= b.idn.raw; }));

}  // namespace

std::span<const CoreValue> core_values() noexcept {
  return kCoreValues;
}

CoreLinks::CoreLinks(const DictionaryTable& table)
    : table_(&table), first_(servoone_idns().rows().data()), links_(servoone_idns().rows().size()) {
  const auto link_of = [this](wire::Idn idn) -> Link& {
    return links_[static_cast<std::size_t>(servoone_idns().find(idn) - first_)];
  };
  for (const auto& row : servoone_idns().rows()) {
    const auto* entry = table.find(object(parameter_number(row.idn)), 0);
    if (is_number(row) && entry != nullptr && !is_string(entry->type)) link_of(row.idn).entry = entry;
  }
  for (const auto& value : kCoreValues) {
    const auto* entry = table.find(value.index, value.subindex);
    auto& link = link_of(value.idn);
    if (entry == nullptr) {
      const auto idn = value.idn.text();
      throw std::logic_error("the drive has no object for " + std::string(idn.data(), idn.size()));
    }
    if (link.entry == nullptr || link.entry == entry) link = {entry, &value};
  }
}

}  // namespace driveline::slaves::msd::sercos
