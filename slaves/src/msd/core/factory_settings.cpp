#include "driveline/slaves/msd/core/factory_settings.hpp"

#include <numbers>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/scaling.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kSoftwareVersionIndex = 0x100A;
constexpr std::uint16_t kNameIndex = 0x2003;
constexpr std::uint16_t kMaxProfileVelocityIndex = 0x607F;

void write_motor(const MotorParameters& motor, ObjectDictionary& dictionary) noexcept {
  const auto real = [&](Slot<float> slot, double number) { dictionary.set(slot, static_cast<float>(number)); };
  const double rated_hz = motor.rated_speed_rad_s * motor.pole_pairs / (2.0 * std::numbers::pi);
  real(kValue.motor_rated_frequency, rated_hz);
  real(kValue.overload_rated_frequency, rated_hz);
  real(kValue.motor_rated_current_a, motor.rated_current_a);
  real(kValue.motor_rated_torque_nm, motor.rated_torque_nm);
  real(kValue.motor_inertia, motor.inertia_kg_m2);
  real(kValue.total_inertia, motor.inertia_kg_m2);
  dictionary.set(kValue.motor_pole_pairs, static_cast<std::uint16_t>(motor.pole_pairs));
  dictionary.set(kValue.motor_rated_current, saturate<std::uint32_t>(motor.rated_current_a * 1e3));
  dictionary.set(kValue.motor_rated_torque, saturate<std::uint32_t>(motor.rated_torque_nm * 1e3));
  dictionary.set(kValue.max_motor_speed, saturate<std::uint32_t>(motor.max_speed_rad_s / kRpm));
  dictionary.set(kValue.encoder_increments, motor.encoder_increments);
  dictionary.set(kValue.velocity_encoder_increments, motor.encoder_increments);
  dictionary.set(kValue.feed, motor.encoder_increments);
}

void write_controller(const ControllerParameters& controller, ObjectDictionary& dictionary) noexcept {
  const auto real = [&](Slot<float> slot, double number) { dictionary.set(slot, static_cast<float>(number)); };
  real(kValue.velocity_gain, controller.velocity_gain_nm_s * kRpm);
  real(kValue.velocity_reset, controller.velocity_reset_s * 1e3);
  real(kValue.velocity_filter, controller.velocity_filter_s * 1e3);
  real(kValue.position_gain, controller.position_gain_per_s * 60.0);
}

}  // namespace

FactoryFacts factory_facts(const MsdParameters& parameters) {
  return {parameters.variant, parameters.firmware_version(), parameters.serial_number, parameters.name,
          parameters.controller.sanitized()};
}

void write_factory_settings(const FactoryFacts& facts, const ServoMotor& motor, ObjectDictionary& dictionary) {
  const auto text = [&](std::uint16_t index) -> std::string& {
    return dictionary.text(dictionary.table().find(index, 0)->slot);
  };
  text(kSoftwareVersionIndex) = facts.firmware.text();
  text(kNameIndex) = facts.name.substr(0, 100);
  dictionary.set(kValue.serial_number, facts.serial_number);
  // A variant without this object has no such limit.
  if (dictionary.table().object(kMaxProfileVelocityIndex).empty()) {
    dictionary.set(kValue.max_profile_velocity, 0xFFFFFFFFU);
  }
  write_motor(motor.parameters(), dictionary);
  write_controller(facts.controller, dictionary);
  const auto characteristic = motor.rated_characteristic();
  dictionary.set(kValue.boost_voltage, static_cast<float>(characteristic.boost_v * kLineRms));
  dictionary.set(kValue.nominal_voltage, static_cast<float>(characteristic.nominal_v * kLineRms));
  dictionary.set(kValue.nominal_frequency, static_cast<float>(characteristic.nominal_hz));
}

}  // namespace driveline::slaves::msd
