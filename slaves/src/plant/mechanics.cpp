#include "driveline/slaves/plant/mechanics.hpp"

#include <algorithm>
#include <cmath>

#include "in_range.hpp"

namespace driveline::slaves {
namespace {

/// Limits the speed beyond any real machine, so that the arithmetic stays finite.
double finite_speed(double rad_s) noexcept {
  constexpr double kBeyondAllMachines = 1e6;
  return std::clamp(rad_s, -kBeyondAllMachines, kBeyondAllMachines);
}

}  // namespace

LoadParameters LoadParameters::sanitized() const noexcept {
  const LoadParameters standard;
  LoadParameters p = *this;
  p.inertia_kg_m2 = in_range(inertia_kg_m2, 0.0, 1e6, 0.0);
  p.stiffness_nm_rad = in_range(stiffness_nm_rad, 0.0, 1e9, standard.stiffness_nm_rad);
  p.damping_nm_s = in_range(damping_nm_s, 0.0, 1e6, standard.damping_nm_s);
  p.coulomb_friction_nm = in_range(coulomb_friction_nm, 0.0, 1e6, 0.0);
  p.gravity_nm = in_range(gravity_nm, -1e6, 1e6, 0.0);
  if (!(end_stop_min_rad < end_stop_max_rad)) {
    p.end_stop_min_rad = standard.end_stop_min_rad;
    p.end_stop_max_rad = standard.end_stop_max_rad;
  }
  p.end_stop_stiffness_nm_rad = in_range(end_stop_stiffness_nm_rad, 0.0, 1e9, standard.end_stop_stiffness_nm_rad);
  p.end_stop_damping_nm_s = in_range(end_stop_damping_nm_s, 0.0, 1e6, standard.end_stop_damping_nm_s);
  return p;
}

Mechanics::Mechanics(const RotorParameters& rotor, const LoadParameters& load, double step_s,
                     double position_rad) noexcept
    : rotor_parameters_(rotor),
      load_parameters_(load.sanitized()),
      step_s_(step_s),
      elastic_(load_parameters_.inertia_kg_m2 > 0.0),
      stopped_by_ends_(std::isfinite(load_parameters_.end_stop_min_rad) ||
                       std::isfinite(load_parameters_.end_stop_max_rad)),
      rotor_{position_rad, 0.0},
      load_{position_rad, 0.0},
      last_position_(position_rad) {
  const double rate = rotor.viscous_friction_nm_s / rotor.inertia_kg_m2;
  speed_decay_ = std::exp(-rate * step_s);
  speed_gain_ =
      rate * step_s > 1e-9 ? (1.0 - speed_decay_) / rotor.viscous_friction_nm_s : step_s / rotor.inertia_kg_m2;
}

/// Applies dry friction, which reduces the speed but cannot reverse it: a slow mass stops.
double Mechanics::with_friction(double velocity, double friction_nm, double inertia) const noexcept {
  const double change = friction_nm * step_s_ / inertia;
  return std::abs(velocity) <= change ? 0.0 : velocity - std::copysign(change, velocity);
}

/// Returns the depth of `position` in an end stop: positive in the upper one, negative in the lower one.
double Mechanics::penetration(double position) const noexcept {
  if (position > load_parameters_.end_stop_max_rad) return position - load_parameters_.end_stop_max_rad;
  if (position < load_parameters_.end_stop_min_rad) return position - load_parameters_.end_stop_min_rad;
  return 0.0;
}

/// Returns the speed after a step against an end stop: spring and damper, implicit; it pushes and never pulls.
double Mechanics::at_end_stop(const Mass& mass, double velocity, double inertia) const noexcept {
  const double inside = penetration(mass.position);
  if (inside == 0.0) return velocity;
  const double k = load_parameters_.end_stop_stiffness_nm_rad;
  const double c = load_parameters_.end_stop_damping_nm_s;
  const double next = (velocity - step_s_ * k * inside / inertia) / (1.0 + step_s_ * (c + step_s_ * k) / inertia);
  const double torque = k * (inside + step_s_ * next) + c * next;
  return (torque > 0.0) == (inside > 0.0) ? next : velocity;
}

/// Whether a mass at rest stays there because the torque on it is within its friction.
bool Mechanics::sticks(const Mass& mass, double torque_nm, double friction_nm) const noexcept {
  return mass.velocity == 0.0 && std::abs(torque_nm) <= friction_nm;
}

/// First the two masses and the coupling move without gaining energy, then friction and end stops only reduce the
/// speed: so no step can add energy.
void Mechanics::step_elastic(double torque_nm, double friction_nm) noexcept {
  const LoadParameters& p = load_parameters_;
  const double elastic = p.stiffness_nm_rad * (rotor_.position - load_.position);
  const double pushed = elastic - p.gravity_nm - p.end_stop_stiffness_nm_rad * penetration(load_.position);
  const double rotor_inverse =
      sticks(rotor_, torque_nm - elastic, friction_nm) ? 0.0 : 1.0 / rotor_parameters_.inertia_kg_m2;
  const double load_inverse = sticks(load_, pushed, p.coulomb_friction_nm) ? 0.0 : 1.0 / p.inertia_kg_m2;

  const double speed = rotor_.velocity - load_.velocity;
  const double factor = 0.25 * p.stiffness_nm_rad * step_s_ + 0.5 * p.damping_nm_s;
  const double inverse = step_s_ * (rotor_inverse + load_inverse);
  const double acceleration = torque_nm * rotor_inverse + p.gravity_nm * load_inverse;
  const double next =
      (speed + step_s_ * acceleration - inverse * (elastic + factor * speed)) / (1.0 + inverse * factor);
  const double coupling = elastic + factor * (speed + next);  // in the middle of the step

  const double rotor_speed = rotor_.velocity + step_s_ * rotor_inverse * (torque_nm - coupling);
  const double load_speed = load_.velocity + step_s_ * load_inverse * (coupling - p.gravity_nm);
  rotor_.position += 0.5 * step_s_ * (rotor_.velocity + rotor_speed);
  load_.position += 0.5 * step_s_ * (load_.velocity + load_speed);

  rotor_.velocity =
      finite_speed(with_friction(speed_decay_ * rotor_speed, friction_nm, rotor_parameters_.inertia_kg_m2));
  const double stopped = stopped_by_ends_ ? at_end_stop(load_, load_speed, p.inertia_kg_m2) : load_speed;
  load_.velocity = finite_speed(with_friction(stopped, p.coulomb_friction_nm, p.inertia_kg_m2));
}

void Mechanics::step_rigid(double torque_nm, double friction_nm) noexcept {
  const double before = rotor_.velocity;
  const double friction = speed_gain_ * (friction_nm + load_parameters_.coulomb_friction_nm);
  const double free = speed_decay_ * before + speed_gain_ * (torque_nm - load_parameters_.gravity_nm);
  double after = std::abs(free) <= friction ? 0.0 : free - std::copysign(friction, free);
  bool touching = false;
  if (stopped_by_ends_) {
    touching = penetration(rotor_.position) != 0.0;
    after = at_end_stop(rotor_, after, rotor_parameters_.inertia_kg_m2);
  }
  rotor_.velocity = finite_speed(after);
  // At a stop, use the speed at the end of the step, as in the stop's implicit equation; otherwise the mean.
  rotor_.position += step_s_ * (touching ? rotor_.velocity : 0.5 * (before + rotor_.velocity));
}

void Mechanics::step(double torque_nm, bool brake_closed) noexcept {
  last_position_ = rotor_.position;
  const double holding_nm = brake_closed ? rotor_parameters_.brake_torque_nm : 0.0;
  const double friction_nm = rotor_parameters_.coulomb_friction_nm + holding_nm + blocking_nm_;
  const double driving_nm = torque_nm - load_nm_;
  elastic_ ? step_elastic(driving_nm, friction_nm) : step_rigid(driving_nm, friction_nm);
}

void Mechanics::set_load(double torque_nm) noexcept {
  load_nm_ = in_range(torque_nm, -1e6, 1e6, 0.0);
}

void Mechanics::set_blocked(bool blocked) noexcept {
  blocking_nm_ = blocked ? 1e7 : 0.0;  // exceeds every torque of the model
}

double Mechanics::kinetic_energy_j() const noexcept {
  return 0.5 * rotor_parameters_.inertia_kg_m2 * rotor_.velocity * rotor_.velocity +
         0.5 * load_parameters_.inertia_kg_m2 * load_.velocity * load_.velocity;
}

double Mechanics::energy_j() const noexcept {
  const double twist = elastic_ ? rotor_.position - load_.position : 0.0;
  const double inside = penetration(load_position_rad());
  return kinetic_energy_j() + 0.5 * load_parameters_.stiffness_nm_rad * twist * twist +
         0.5 * load_parameters_.end_stop_stiffness_nm_rad * inside * inside +
         load_parameters_.gravity_nm * load_position_rad();
}

}  // namespace driveline::slaves
