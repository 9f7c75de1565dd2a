#include "driveline/slaves/plant/servo_motor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::slaves {
namespace {

double in_range(double value, double low, double high, double fallback) noexcept {
  return std::isfinite(value) ? std::clamp(value, low, high) : fallback;
}

}  // namespace

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
  p.pole_pairs = std::clamp(pole_pairs, 1U, 100U);
  p.torque_lag_s = in_range(torque_lag_s, 0.0, 1.0, standard.torque_lag_s);
  p.max_speed_rad_s = in_range(max_speed_rad_s, 1.0, 1e5, standard.max_speed_rad_s);
  p.encoder_increments = std::clamp(encoder_increments, 4U, 1U << 28U);
  return p;
}

ServoMotor::ServoMotor(const MotorParameters& parameters, double step_s, double position_rad) noexcept
    : parameters_(parameters.sanitized()),
      step_s_(step_s),
      torque_gain_(parameters_.torque_lag_s > 0.0 ? -std::expm1(-step_s / parameters_.torque_lag_s) : 1.0),
      radians_per_increment_(2.0 * std::numbers::pi / parameters_.encoder_increments),
      increments_per_radian_(1.0 / radians_per_increment_),
      position_rad_(in_range(position_rad, -1e6, 1e6, 0.0)),
      last_position_rad_(position_rad_) {
  const double rate = parameters_.viscous_friction_nm_s / parameters_.inertia_kg_m2;
  speed_decay_ = std::exp(-rate * step_s);
  speed_gain_ = rate * step_s > 1e-9 ? (1.0 - speed_decay_) / parameters_.viscous_friction_nm_s
                                     : step_s / parameters_.inertia_kg_m2;
}

void ServoMotor::step(double torque_setpoint_nm, bool brake_closed) noexcept {
  const double setpoint = in_range(torque_setpoint_nm, -parameters_.peak_torque_nm, parameters_.peak_torque_nm, 0.0);
  torque_nm_ += torque_gain_ * (setpoint - torque_nm_);

  const double before = velocity_rad_s_;
  const double without_friction = speed_decay_ * before + speed_gain_ * torque_nm_;
  const double holding_nm = brake_closed ? parameters_.brake_torque_nm : 0.0;
  const double friction = speed_gain_ * (parameters_.coulomb_friction_nm + holding_nm);
  // Dry friction takes away speed but cannot turn it round: within its reach the shaft sticks.
  const double after =
      std::abs(without_friction) <= friction ? 0.0 : without_friction - std::copysign(friction, without_friction);
  velocity_rad_s_ = std::clamp(after, -parameters_.max_speed_rad_s, parameters_.max_speed_rad_s);
  last_position_rad_ = position_rad_;
  position_rad_ += 0.5 * step_s_ * (before + velocity_rad_s_);
}

std::optional<std::int64_t> ServoMotor::index_pulse() const noexcept {
  const double revolution = 2.0 * std::numbers::pi;
  const double before = std::floor(last_position_rad_ / revolution);
  const double now = std::floor(position_rad_ / revolution);
  if (!(before < now) && !(now < before)) return std::nullopt;
  const double turn = now > before ? now : now + 1.0;
  return static_cast<std::int64_t>(turn) * parameters_.encoder_increments;
}

std::int64_t ServoMotor::encoder_count(double position_rad) const noexcept {
  return static_cast<std::int64_t>(std::floor(position_rad * increments_per_radian_));
}

}  // namespace driveline::slaves
