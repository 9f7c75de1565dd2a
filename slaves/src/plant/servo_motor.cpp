#include "driveline/slaves/plant/servo_motor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "in_range.hpp"

namespace driveline::slaves {

MotorParameters MotorParameters::sanitized() const noexcept {
  const MotorParameters standard;
  MotorParameters p = *this;
  p.rated_torque_nm = in_range(rated_torque_nm, 1e-6, 1e6, standard.rated_torque_nm);
  p.peak_torque_nm =
      in_range(peak_torque_nm, p.rated_torque_nm, 1e7, std::max(standard.peak_torque_nm, p.rated_torque_nm));
  p.rated_current_a = in_range(rated_current_a, 1e-3, 1e5, standard.rated_current_a);
  p.inertia_kg_m2 = in_range(inertia_kg_m2, 1e-9, 1e6, standard.inertia_kg_m2);
  p.viscous_friction_nm_s = in_range(viscous_friction_nm_s, 0.0, 1e6, standard.viscous_friction_nm_s);
  p.coulomb_friction_nm = in_range(coulomb_friction_nm, 0.0, 1e6, standard.coulomb_friction_nm);
  p.brake_torque_nm = in_range(brake_torque_nm, 0.0, 1e7, standard.brake_torque_nm);
  p.encoder_noise_increments = in_range(encoder_noise_increments, 0.0, 1e6, 0.0);
  p.winding.resistance_ohm = in_range(winding.resistance_ohm, 1e-6, 1e6, standard.winding.resistance_ohm);
  p.winding.inductance_h = in_range(winding.inductance_h, 1e-7, 1e3, standard.winding.inductance_h);
  p.winding.saturation_current_a = in_range(winding.saturation_current_a, 0.0, 1e6, 0.0);
  p.load = load.sanitized();
  p.pole_pairs = std::clamp(pole_pairs, 1U, 100U);
  p.torque_lag_s = in_range(torque_lag_s, 0.0, 1.0, standard.torque_lag_s);
  p.max_speed_rad_s = in_range(max_speed_rad_s, 1.0, 1e5, standard.max_speed_rad_s);
  p.rated_speed_rad_s = in_range(rated_speed_rad_s, 1.0, p.max_speed_rad_s, standard.rated_speed_rad_s);
  p.encoder_increments = std::clamp(encoder_increments, 4U, 1U << 28U);
  return p;
}

/// At equal voltages the current is proportional to the power.
double MotorParameters::typical_current_a() const noexcept {
  const MotorParameters standard;
  return standard.rated_current_a * (rated_torque_nm / standard.rated_torque_nm) *
         (max_speed_rad_s / standard.max_speed_rad_s);
}

WindingParameters MotorParameters::typical_winding() const noexcept {
  const MotorParameters standard;
  // Up to constant factors: flux per rated current, and back EMF per rated current at the maximum speed.
  const auto inductance = [](const MotorParameters& p) {
    return p.rated_torque_nm / (p.pole_pairs * p.rated_current_a * p.rated_current_a);
  };
  const auto resistance = [&](const MotorParameters& p) { return inductance(p) * p.pole_pairs * p.max_speed_rad_s; };
  WindingParameters typical = winding;
  typical.inductance_h = standard.winding.inductance_h * inductance(*this) / inductance(standard);
  typical.resistance_ohm = standard.winding.resistance_ohm * resistance(*this) / resistance(standard);
  return typical;
}

ServoMotor::ServoMotor(const MotorParameters& parameters, double step_s, double position_rad) noexcept
    : parameters_(parameters.sanitized()),
      torque_constant_(parameters_.rated_torque_nm / (std::numbers::sqrt2 * parameters_.rated_current_a)),
      torque_gain_(parameters_.torque_lag_s > 0.0 ? -std::expm1(-step_s / parameters_.torque_lag_s) : 1.0),
      radians_per_increment_(2.0 * std::numbers::pi / parameters_.encoder_increments),
      increments_per_radian_(1.0 / radians_per_increment_),
      current_(parameters_.winding, torque_constant_, parameters_.pole_pairs, parameters_.torque_lag_s, step_s),
      peak_current_(current_.holding(parameters_.peak_torque_nm / torque_constant_)),
      mechanics_({parameters_.inertia_kg_m2, parameters_.viscous_friction_nm_s, parameters_.coulomb_friction_nm,
                  parameters_.brake_torque_nm},
                 parameters_.load, step_s, in_range(position_rad, -1e6, 1e6, 0.0)),
      through_windings_(parameters_.winding.simulated),
      random_(parameters_.encoder_seed != 0 ? parameters_.encoder_seed : 1) {
  count_ = encoder_count(this->position_rad());
  pass_index(this->position_rad());
  passed_index_ = false;
}

void ServoMotor::finish_step(bool brake_closed) noexcept {
  mechanics_.step(torque_nm_, brake_closed);
  const double position = mechanics_.position_rad();
  count_ = encoder_count(position);
  passed_index_ = false;
  if (position < turn_begin_rad_ || position >= turn_end_rad_) pass_index(position);
  if (parameters_.encoder_noise_increments > 0.0) draw_noise();
}

void ServoMotor::step(double torque_setpoint_nm, const TorqueRange& range, bool brake_closed) noexcept {
  const double setpoint = in_range(torque_setpoint_nm, range.lowest_nm, range.highest_nm, 0.0);
  if (through_windings_) {
    const double speed = mechanics_.velocity_rad_s();
    if (shorted_) {
      torque_nm_ = current_.step_voltage(0.0, 0.0, speed, dc_link_volts_);
    } else if (powered()) {
      torque_nm_ = current_.step(setpoint, speed, dc_link_volts_);
    } else {
      torque_nm_ = 0.0;
      current_.open_circuit();
    }
  } else {
    torque_nm_ += torque_gain_ * ((powered() ? setpoint : 0.0) - torque_nm_);
  }
  finish_step(brake_closed);
}

void ServoMotor::step(const VoltageVector& voltage, bool brake_closed) noexcept {
  if (shorted_) return step(0.0, brake_closed);
  const double turn = voltage.angle_rad - electrical_angle_rad();
  const double d_v = voltage.in_phase_v * std::cos(turn) - voltage.quadrature_v * std::sin(turn);
  const double q_v = voltage.in_phase_v * std::sin(turn) + voltage.quadrature_v * std::cos(turn);
  torque_nm_ = powered() ? current_.step_voltage(d_v, q_v, mechanics_.velocity_rad_s(), dc_link_volts_) : 0.0;
  if (!powered()) current_.open_circuit();
  finish_step(brake_closed);
}

TorqueRange ServoMotor::reduced_torque_range() const noexcept {
  const double peak = parameters_.peak_torque_nm;
  const CurrentRange range = current_.holdable(mechanics_.velocity_rad_s(), dc_link_volts_);
  return {std::clamp(torque_constant_ * range.lowest_a, -peak, peak),
          std::clamp(torque_constant_ * range.highest_a, -peak, peak)};
}

/// The windings continue with the present torque, and their current control with the present currents.
void ServoMotor::use_windings(bool before) noexcept {
  through_windings_ = parameters_.winding.simulated || by_voltage_ || shorted_;
  if (through_windings_ && !before) current_.settle(torque_nm_, mechanics_.velocity_rad_s());
  if (!by_voltage_ && !shorted_) current_.resume();
}

void ServoMotor::drive_by_voltage(bool by_voltage) noexcept {
  by_voltage_ = by_voltage;
  use_windings(through_windings_);
}

void ServoMotor::set_short_circuit(bool shorted) noexcept {
  if (shorted == shorted_) return;
  shorted_ = shorted;
  use_windings(through_windings_);
}

void ServoMotor::set_encoder_connected(bool connected) noexcept {
  if (!connected) held_count_ = encoder_count();
  encoder_connected_ = connected;
}

double ServoMotor::power_w() const noexcept {
  if (shorted_) return 0.0;
  const double current = current_a();
  return torque_nm_ * velocity_rad_s() + 1.5 * parameters_.winding.resistance_ohm * current * current;
}

VoltageFrequencyParameters ServoMotor::rated_characteristic() const noexcept {
  constexpr double kBoostShare = 0.8;  // stays below the limits of the overload monitoring
  const MotorParameters& p = parameters_;
  const double current = std::numbers::sqrt2 * p.rated_current_a;
  const double electrical = p.pole_pairs * p.max_speed_rad_s;
  const double flux = torque_constant_ / (1.5 * p.pole_pairs);
  VoltageFrequencyParameters characteristic;
  characteristic.boost_v = kBoostShare * p.winding.resistance_ohm * current;
  characteristic.nominal_v =
      std::hypot(electrical * flux + p.winding.resistance_ohm * current, electrical * p.winding.inductance_h * current);
  characteristic.nominal_hz = electrical / (2.0 * std::numbers::pi);
  characteristic.rated_current_a = current;
  characteristic.max_current_a = current * p.peak_torque_nm / p.rated_torque_nm;
  return characteristic;
}

double ServoMotor::current_a() const noexcept {
  return through_windings_ ? current_.current_a() : std::abs(torque_nm_) / torque_constant_;
}

/// xorshift32: the same sequence for the same seed on every machine.
void ServoMotor::draw_noise() noexcept {
  random_ ^= random_ << 13U;
  random_ ^= random_ >> 17U;
  random_ ^= random_ << 5U;
  const double share = static_cast<double>(random_) / 2147483648.0 - 1.0;
  noise_ = std::llrint(share * parameters_.encoder_noise_increments);
}

std::int64_t ServoMotor::power_on_origin() const noexcept {
  const std::int64_t count = encoder_count(position_rad());
  if (parameters_.encoder_turns == 0) return count;
  if (parameters_.encoder_turns == MotorParameters::kAllTurns) return 0;
  const std::int64_t range = std::int64_t{parameters_.encoder_turns} * parameters_.encoder_increments;
  const std::int64_t rest = count % range;
  return count - (rest < 0 ? rest + range : rest);
}

void ServoMotor::pass_index(double position_rad) noexcept {
  constexpr double kRevolution = 2.0 * std::numbers::pi;
  const double before = std::round(turn_begin_rad_ / kRevolution);
  const double now = std::floor(position_rad / kRevolution);
  turn_begin_rad_ = now * kRevolution;
  turn_end_rad_ = (now + 1.0) * kRevolution;
  const double turn = now > before ? now : now + 1.0;
  index_count_ = static_cast<std::int64_t>(turn) * parameters_.encoder_increments;
  passed_index_ = true;
}

}  // namespace driveline::slaves
