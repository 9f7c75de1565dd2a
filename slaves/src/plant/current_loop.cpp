#include "driveline/slaves/plant/current_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "in_range.hpp"

namespace driveline::slaves {

CurrentLoop::CurrentLoop(const WindingParameters& parameters, double torque_constant, unsigned pole_pairs, double lag_s,
                         double step_s) noexcept
    : parameters_(parameters),
      torque_constant_(at_least(torque_constant, 1e-6)),
      pole_pairs_(pole_pairs),
      step_s_(step_s) {
  parameters_.resistance_ohm = at_least(parameters.resistance_ohm, 1e-6);
  parameters_.inductance_h = at_least(parameters.inductance_h, 1e-7);
  parameters_.saturation_current_a = at_least(parameters.saturation_current_a, 0.0);
  flux_vs_ = torque_constant_ / (1.5 * pole_pairs_);
  // Pole-zero cancellation: the closed loop is a lag with this time constant, but no faster than three steps.
  const double bandwidth = 1.0 / std::max(at_least(lag_s, 0.0), 3.0 * step_s);
  proportional_v_a_ = bandwidth * parameters_.inductance_h;
  integral_v_a_ = bandwidth * parameters_.resistance_ohm * step_s;
}

double CurrentLoop::torque_nm() const noexcept {
  if (!(parameters_.saturation_current_a > 0.0)) return torque_constant_ * q_a_;
  const double share = q_a_ / parameters_.saturation_current_a;
  return torque_constant_ * q_a_ / std::sqrt(1.0 + share * share);
}

double CurrentLoop::loss_w() const noexcept {
  return 1.5 * parameters_.resistance_ohm * (d_a_ * d_a_ + q_a_ * q_a_);
}

/// In reality the diodes extinguish the current within fractions of a millisecond; here it is 0 at once.
void CurrentLoop::open_circuit() noexcept {
  d_a_ = q_a_ = 0.0;
  d_v_ = q_v_ = 0.0;
  d_integral_v_ = q_integral_v_ = 0.0;
  limited_ = false;
}

double CurrentLoop::step(double torque_setpoint_nm, double speed_rad_s, double dc_link_volts) noexcept {
  const double wanted_a = finite(torque_setpoint_nm) / torque_constant_;
  const double speed = pole_pairs_ * finite(speed_rad_s);
  const double d_error = -d_a_;
  const double q_error = wanted_a - q_a_;
  const double reactance = speed * parameters_.inductance_h;
  const double d_v = proportional_v_a_ * d_error + d_integral_v_ - reactance * q_a_;
  const double q_v = proportional_v_a_ * q_error + q_integral_v_ + reactance * d_a_ + speed * flux_vs_;
  if (!drive_windings(d_v, q_v, speed, dc_link_volts)) {  // anti-windup: no integration at the limit
    d_integral_v_ += integral_v_a_ * d_error;
    q_integral_v_ += integral_v_a_ * q_error;
  }
  return torque_nm();
}

bool CurrentLoop::drive_windings(double d_v, double q_v, double speed, double dc_link_volts) noexcept {
  const double limit = std::max(finite(dc_link_volts), 0.0) / std::numbers::sqrt3;
  const double amplitude = std::hypot(d_v, q_v);
  limited_ = amplitude > limit;
  if (limited_) {
    d_v *= limit / amplitude;
    q_v *= limit / amplitude;
  }
  d_v_ = d_v;
  q_v_ = q_v;
  // Implicit integration of the windings is stable at every speed.
  const double share = step_s_ / parameters_.inductance_h;
  const double diagonal = 1.0 + share * parameters_.resistance_ohm;
  const double cross = step_s_ * speed;
  const double d_right = d_a_ + share * d_v;
  const double q_right = q_a_ + share * (q_v - speed * flux_vs_);
  const double determinant = diagonal * diagonal + cross * cross;
  d_a_ = (diagonal * d_right + cross * q_right) / determinant;
  q_a_ = (diagonal * q_right - cross * d_right) / determinant;
  return limited_;
}

double CurrentLoop::step_voltage(double d_v, double q_v, double speed_rad_s, double dc_link_volts) noexcept {
  drive_windings(finite(d_v), finite(q_v), pole_pairs_ * finite(speed_rad_s), dc_link_volts);
  return torque_nm();
}

void CurrentLoop::settle(double torque_nm, double speed_rad_s) noexcept {
  const double speed = pole_pairs_ * finite(speed_rad_s);
  d_a_ = 0.0;
  q_a_ = finite(torque_nm) / torque_constant_;
  d_v_ = -speed * parameters_.inductance_h * q_a_;
  q_v_ = parameters_.resistance_ohm * q_a_ + speed * flux_vs_;
}

void CurrentLoop::resume() noexcept {
  d_integral_v_ = parameters_.resistance_ohm * d_a_;
  q_integral_v_ = parameters_.resistance_ohm * q_a_;
}

/// Steady state: (w flux + R i)^2 + (w L i)^2 = V^2.
CurrentRange CurrentLoop::holdable(double speed_rad_s, double dc_link_volts) const noexcept {
  const double speed = pole_pairs_ * finite(speed_rad_s);
  const double limit = std::max(finite(dc_link_volts), 0.0) / std::numbers::sqrt3;
  const double resistance = parameters_.resistance_ohm;
  const double reactance = speed * parameters_.inductance_h;
  const double emf = speed * flux_vs_;
  const double square = resistance * resistance + reactance * reactance;
  const double inside = square * limit * limit - emf * emf * reactance * reactance;
  const double middle = -resistance * emf / square;
  const double half = inside > 0.0 ? std::sqrt(inside) / square : 0.0;
  return {middle - half, middle + half};
}

double CurrentLoop::active_current_a() const noexcept {
  const double amplitude = std::hypot(d_v_, q_v_);
  return amplitude > 0.0 ? (d_v_ * d_a_ + q_v_ * q_a_) / amplitude : 0.0;
}

/// Steady state: q current = (V Z sin(angle - phase) - R w flux) / Z^2 with Z and phase of the winding's impedance.
double CurrentLoop::voltage_angle_rad(double amplitude_v, double torque_nm, double speed_rad_s) const noexcept {
  const double speed = pole_pairs_ * finite(speed_rad_s);
  const double resistance = parameters_.resistance_ohm;
  const double reactance = speed * parameters_.inductance_h;
  const double impedance = std::hypot(resistance, reactance);
  const double phase = std::atan2(reactance, resistance);
  const double needed = finite(torque_nm) / torque_constant_ * impedance + resistance * speed * flux_vs_ / impedance;
  return phase + std::asin(std::clamp(needed / at_least(amplitude_v, 1e-9), -1.0, 1.0));
}

}  // namespace driveline::slaves
