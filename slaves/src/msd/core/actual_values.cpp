#include "driveline/slaves/msd/core/actual_values.hpp"

#include <numbers>

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

/// Returns a torque in per mille of the rated torque, the unit of 6074h and 6077h.
std::int16_t torque_permille(double torque_nm, const DriveMotion& motion) noexcept {
  return saturate<std::int16_t>(1000.0 * torque_nm / motion.settings().rated_torque_nm);
}

/// P 412-P 419: the values of the profile's objects, in units of the motor.
void publish_motor_values(const DriveMotion& motion, ObjectDictionary& dictionary) noexcept {
  const auto actual = static_cast<std::uint32_t>(motion.motor().encoder_count());
  const auto difference = saturate<std::int32_t>(motion.following_error_increments());
  dictionary.set(kValue.actual_increments, static_cast<std::int32_t>(actual));
  dictionary.set(kValue.reference_increments,
                 static_cast<std::int32_t>(actual + static_cast<std::uint32_t>(difference)));
  dictionary.set(kValue.increment_difference, difference);
  dictionary.set(kValue.actual_rpm, static_cast<float>(motion.controller().measured_velocity_rad_s() / kRpm));
  dictionary.set(kValue.reference_rpm, static_cast<float>(motion.controller().velocity_setpoint_rad_s() / kRpm));
  dictionary.set(kValue.reference_torque_nm, static_cast<float>(motion.torque_demand_nm()));
  dictionary.set(kValue.actual_torque_nm, static_cast<float>(motion.torque_nm()));
}

}  // namespace

ValueGroups value_group(std::uint16_t slot) noexcept {
  switch (slot) {
    case kValue.position_actual.number:
      return ValueGroup::kPosition;
    case kValue.position_demand.number:
    case kValue.following_error.number:
      return ValueGroup::kPositionDemand;
    case kValue.velocity_actual.number:
      return ValueGroup::kVelocity;
    case kValue.velocity_demand.number:
      return ValueGroup::kVelocityDemand;
    case kValue.torque_actual.number:
      return ValueGroup::kTorque;
    case kValue.current_actual.number:
      return ValueGroup::kCurrent;
    case kValue.torque_demand.number:
      return ValueGroup::kTorqueDemand;
    case kValue.actual_increments.number:
    case kValue.reference_increments.number:
    case kValue.increment_difference.number:
    case kValue.actual_rpm.number:
    case kValue.reference_rpm.number:
    case kValue.reference_torque_nm.number:
    case kValue.actual_torque_nm.number:
      return ValueGroup::kMotor;
    case kValue.touch_probe_status.number:
      return ValueGroup::kTouchProbe;
    case kValue.input_state.number:
    case kValue.digital_inputs.number:
    case kValue.output_state.number:
      return ValueGroup::kTerminals;
    default:
      return kValue.touch_probe_values.contains(slot) ? ValueGroups(ValueGroup::kTouchProbe) : ValueGroups();
  }
}

void ActualValues::publish(ValueGroups groups, const DriveMotion& motion, ObjectDictionary& dictionary) const noexcept {
  const PositionRangeLimit& range = motion.settings().range;
  const std::int64_t position = motion.position();
  if (groups.has(ValueGroup::kPosition) && !position_held_) {
    dictionary.set(kValue.position_actual, range.wrap(position + position_error_));
  }
  if (groups.has(ValueGroup::kPositionDemand)) {
    const double demand = motion.position_demand();
    dictionary.set(kValue.position_demand, range.wrap(std::llrint(demand)));
    dictionary.set(kValue.following_error, saturate<std::int32_t>(demand - static_cast<double>(position)));
  }
  if (groups.has(ValueGroup::kVelocity)) {
    dictionary.set(kValue.velocity_actual, saturate<std::int32_t>(motion.velocity()));
  }
  if (groups.has(ValueGroup::kTorque)) {
    dictionary.set(kValue.torque_actual, torque_permille(motion.torque_nm(), motion));
  }
  constexpr auto kUsual = ValueGroups(ValueGroup::kPosition)
                              .with(ValueGroup::kPositionDemand)
                              .with(ValueGroup::kVelocity)
                              .with(ValueGroup::kTorque);
  if (!groups.without(kUsual).empty()) publish_unusual(groups, motion, dictionary);
}

/// Publishes the groups that a bus seldom sends.
void ActualValues::publish_unusual(ValueGroups groups, const DriveMotion& motion,
                                   ObjectDictionary& dictionary) const noexcept {
  if (groups.has(ValueGroup::kVelocityDemand)) {
    dictionary.set(kValue.velocity_demand, saturate<std::int32_t>(motion.velocity_demand()));
  }
  if (groups.has(ValueGroup::kCurrent)) {
    // Sign of the torque, amplitude of both currents: with saturated iron or d current it exceeds that of the torque.
    const auto torque = torque_permille(motion.torque_nm(), motion);
    const double permille =
        1000.0 * motion.motor().current_a() / (std::numbers::sqrt2 * motion.settings().rated_current_a);
    dictionary.set(kValue.current_actual, saturate<std::int16_t>(std::copysign(permille, torque)));
  }
  if (groups.has(ValueGroup::kTorqueDemand)) {
    dictionary.set(kValue.torque_demand, torque_permille(motion.torque_demand_nm(), motion));
  }
  if (groups.has(ValueGroup::kMotor)) publish_motor_values(motion, dictionary);
}

void publish(const Terminals& terminals, ObjectDictionary& dictionary) noexcept {
  dictionary.set(kValue.input_state, terminals.input_image());
  dictionary.set(kValue.digital_inputs, terminals.function_image());
  dictionary.set(kValue.output_state, terminals.output_image());
}

void publish(const TouchProbe& probe, ObjectDictionary& dictionary) noexcept {
  dictionary.set(kValue.touch_probe_status, probe.status());
  for (std::size_t i = 0; i < TouchProbe::kValues; ++i) {
    dictionary.set(kValue.touch_probe_values[i], probe.value(static_cast<TouchProbe::Value>(i)));
  }
}

}  // namespace driveline::slaves::msd
