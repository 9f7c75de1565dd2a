#include "driveline/slaves/msd/core/actual_values.hpp"

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

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

void ActualValues::publish(const DriveMotion& motion, ObjectDictionary& dictionary) const noexcept {
  const PositionRangeLimit& range = motion.settings().range;
  const auto torque = saturate<std::int16_t>(motion.torque_permille());
  const std::int64_t position = motion.position();
  const double demand = motion.position_demand();
  if (!position_held_) dictionary.set(kValue.position_actual, range.wrap(position + position_error_));
  dictionary.set(kValue.position_demand, range.wrap(std::llrint(demand)));
  dictionary.set(kValue.following_error, saturate<std::int32_t>(demand - static_cast<double>(position)));
  dictionary.set(kValue.velocity_actual, saturate<std::int32_t>(motion.velocity()));
  dictionary.set(kValue.velocity_demand, saturate<std::int32_t>(motion.velocity_demand()));
  dictionary.set(kValue.torque_actual, torque);
  // Sign of the torque, amplitude of both currents: with saturated iron or d current it exceeds that of the torque.
  dictionary.set(kValue.current_actual, saturate<std::int16_t>(std::copysign(motion.current_permille(), torque)));
  dictionary.set(kValue.torque_demand, saturate<std::int16_t>(motion.torque_demand_permille()));
  publish_motor_values(motion, dictionary);
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
