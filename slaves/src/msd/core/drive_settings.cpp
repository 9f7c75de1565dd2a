#include "driveline/slaves/msd/core/drive_settings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::nanoseconds;

constexpr std::int16_t kJerkLimited = 3;       ///< 6086h
constexpr std::uint16_t kThermalOverload = 1;  ///< P 735

/// Reads values of the dictionary as doubles.
class Reader {
 public:
  explicit Reader(const ObjectDictionary& dictionary) noexcept : dictionary_(dictionary) {}
  [[nodiscard]] double operator()(Slot<float> slot) const noexcept { return dictionary_.get(slot); }
  [[nodiscard]] double operator()(Slot<std::uint32_t> slot) const noexcept { return dictionary_.get(slot); }
  [[nodiscard]] double operator()(Slot<std::uint16_t> slot) const noexcept { return dictionary_.get(slot); }

 private:
  const ObjectDictionary& dictionary_;
};

/// Returns 60C2h in control cycles.
std::uint32_t steps_per_setpoint(const ObjectDictionary& dictionary) noexcept {
  const double period_s = dictionary.get(kValue.interpolation_period_value) *
                          std::pow(10.0, dictionary.get(kValue.interpolation_period_index));
  return std::max(saturate<std::uint32_t>(period_s / kControlStepS), 1U);
}

ControllerParameters controller_settings(const Reader& value, const MotionSettings& s, double peak_torque_nm) noexcept {
  ControllerParameters controller;
  controller.position_gain_per_s = value(kValue.position_gain) / 60.0;
  controller.velocity_gain_nm_s = value(kValue.velocity_gain) / kRpm * value(kValue.velocity_gain_scale) * 1e-2;
  controller.velocity_reset_s = value(kValue.velocity_reset) * 1e-3;
  controller.velocity_filter_s = value(kValue.velocity_filter) * 1e-3;
  controller.max_velocity_rad_s = value(kValue.max_motor_speed) * kRpm;
  controller.max_torque_nm =
      std::min(peak_torque_nm / s.torque_per_demand, value(kValue.max_torque) * 1e-3 * s.rated_torque_nm);
  return controller;
}

/// P 457 and P 460 are the motor data with which the drive converts torque to current.
void set_motor_data(const Reader& value, const MotorParameters& motor, MotionSettings& s) noexcept {
  s.rated_current_a = value(kValue.motor_rated_current_a);
  s.rated_torque_nm = value(kValue.motor_rated_torque_nm);
  s.torque_per_demand = (s.rated_current_a / motor.rated_current_a) / (s.rated_torque_nm / motor.rated_torque_nm);
}

void set_characteristic(const Reader& value, MotionSettings& s) noexcept {
  s.voltage_frequency.boost_v = value(kValue.boost_voltage) / kLineRms;
  s.voltage_frequency.nominal_v = value(kValue.nominal_voltage) / kLineRms;
  s.voltage_frequency.nominal_hz = value(kValue.nominal_frequency);
  s.voltage_frequency.max_current_a =
      std::numbers::sqrt2 * s.rated_current_a * s.controller.max_torque_nm / s.rated_torque_nm;
}

void set_feed_forward(const ObjectDictionary& dictionary, Variant variant, MotionSettings& s) noexcept {
  const Reader value(dictionary);
  s.speed_feed_forward = value(kValue.speed_feed_forward_scale) * 1e-2;
  s.torque_feed_forward = value(kValue.torque_feed_forward_scale) * 1e-2;
  s.feed_forward_inertia_kg_m2 = value(kValue.total_inertia);
  s.external_speed_feed_forward = dictionary.get(kValue.speed_feed_forward_source) != 0;
  s.external_torque_feed_forward = dictionary.get(kValue.torque_feed_forward_source) != 0;
  const bool external_spline = s.method == FineInterpolator::Method::kExternal;
  if (facts(variant).external_feed_forward_needs_spline) {
    s.external_speed_feed_forward = s.external_speed_feed_forward && external_spline;
    s.external_torque_feed_forward = s.external_torque_feed_forward && external_spline;
  } else if (external_spline) {
    // The controller sends speed and torque with every position (MSD manual Table 12.16).
    s.external_speed_feed_forward = s.external_torque_feed_forward = true;
  }
}

}  // namespace

MotionSettings motion_settings(const ObjectDictionary& dictionary, const ServoMotor& motor, Variant variant,
                               const Scaling& scaling) noexcept {
  const Reader value(dictionary);
  MotionSettings s;
  s.scaling = scaling;
  set_motor_data(value, motor.parameters(), s);
  s.range = {dictionary.get(kValue.range_min), dictionary.get(kValue.range_max)};
  s.controller = controller_settings(value, s, motor.parameters().peak_torque_nm);
  s.method = static_cast<FineInterpolator::Method>(dictionary.get(kValue.interpolation_type));
  s.steps_per_setpoint = steps_per_setpoint(dictionary);
  set_feed_forward(dictionary, variant, s);
  s.slow_down_rad_s2 = value(kValue.profile_deceleration) * s.scaling.acceleration_rad_s2;
  s.quick_stop_rad_s2 = value(kValue.quick_stop_deceleration) * s.scaling.acceleration_rad_s2;
  s.voltage_frequency = motor.rated_characteristic();
  set_characteristic(value, s);
  s.jerk_time_s = dictionary.get(kValue.motion_profile_type) == kJerkLimited ? value(kValue.jerk_time) * 1e-3 : 0.0;
  s.standstill_rad_s = value(kValue.standstill_window) * kRpm;
  s.position_min = dictionary.get(kValue.position_limit_min);
  s.position_max = dictionary.get(kValue.position_limit_max);
  s.position_limited = s.position_min < s.position_max;
  return s;
}

void follow_motor_data(ObjectDictionary& dictionary) noexcept {
  const Reader value(dictionary);
  dictionary.set(kValue.motor_rated_current, saturate<std::uint32_t>(value(kValue.motor_rated_current_a) * 1e3));
  dictionary.set(kValue.motor_rated_torque, saturate<std::uint32_t>(value(kValue.motor_rated_torque_nm) * 1e3));
}

OverloadLimits overload_limits(const ObjectDictionary& dictionary, double rated_current_a) noexcept {
  const Reader value(dictionary);
  return {dictionary.get(kValue.overload_type) == kThermalOverload,
          value(kValue.overload_time_constant),
          value(kValue.overload_rated) * 1e-2,
          value(kValue.overload_standstill) * 1e-2,
          value(kValue.overload_middle) * 1e-2,
          value(kValue.overload_middle_frequency),
          value(kValue.overload_rated_frequency),
          value(kValue.motor_rated_current_a) / rated_current_a};
}

nanoseconds reference_cycle(const ObjectDictionary& dictionary) noexcept {
  return nanoseconds{std::llrint(dictionary.get(kValue.reference_cycle) * 1e6)};
}

bool timing_valid(const ObjectDictionary& dictionary) noexcept {
  std::int64_t period_ns = dictionary.get(kValue.interpolation_period_value);
  for (auto exponent = dictionary.get(kValue.interpolation_period_index); exponent > -9; --exponent) period_ns *= 10;
  return reference_cycle(dictionary).count() == period_ns && period_ns % kProcessDataPeriod.count() == 0;
}

}  // namespace driveline::slaves::msd
