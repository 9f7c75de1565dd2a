#pragma once

#include <limits>

namespace driveline::slaves {

/// The load, seen from the motor shaft.
struct LoadParameters {
  double inertia_kg_m2 = 0.0;        ///< behind an elastic coupling; 0: the load is rigidly part of the motor's inertia
  double stiffness_nm_rad = 200.0;   ///< of the coupling
  double damping_nm_s = 0.01;        ///< of the coupling
  double coulomb_friction_nm = 0.0;  ///< dry friction of the load; 0 or more
  double gravity_nm = 0.0;           ///< torque of a weight, in negative direction
  /// Position of the load at the lower end stop; infinite: none
  double end_stop_min_rad = -std::numeric_limits<double>::infinity();
  /// The same of the upper one; both must be in order, else there are none
  double end_stop_max_rad = std::numeric_limits<double>::infinity();
  double end_stop_stiffness_nm_rad = 500.0;  ///< spring of either end stop
  double end_stop_damping_nm_s = 0.05;       ///< Nm per rad/s, of either end stop; takes energy, never pulls

  /// The same load with every value in the range the model is stable in. \rtsafe
  [[nodiscard]] LoadParameters sanitized() const noexcept;
};

/// Inertia and friction of the motor itself.
struct RotorParameters {
  double inertia_kg_m2 = 3.0e-4;          ///< at the shaft; above 0
  double viscous_friction_nm_s = 2.0e-4;  ///< Nm per rad/s
  double coulomb_friction_nm = 0.03;      ///< dry friction
  double brake_torque_nm = 0.0;           ///< of the closed holding brake; 0: none
};

/// One or two masses with friction, brake, gravity and end stops. The coupling is integrated by the implicit midpoint
/// rule, which keeps its energy exactly, everything that takes energy away implicitly: without torque the model never
/// gains energy, whatever the step length and the parameters. An end stop that is hard for the step length may hold
/// more for a moment than the impact had; it does not give it back.
class Mechanics {
 public:
  /// At rest at `position_rad`. `step_s`: length of every step(), above 0.
  Mechanics(const RotorParameters& rotor, const LoadParameters& load, double step_s, double position_rad) noexcept;

  /// One step with this torque at the rotor. \rtsafe
  void step(double torque_nm, bool brake_closed) noexcept;
  /// A torque at the rotor besides the motor's, as of a weight: positive pulls in negative direction. \rtsafe
  void set_load(double torque_nm) noexcept;
  /// The rotor is stuck, or free again. \rtsafe
  void set_blocked(bool blocked) noexcept;
  /// Torque of set_load(). \rtsafe
  [[nodiscard]] double load_nm() const noexcept { return load_nm_; }
  /// The rotor is stuck. \rtsafe
  [[nodiscard]] bool blocked() const noexcept { return blocking_nm_ > 0.0; }

  /// Of the rotor, not wrapped. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return rotor_.position; }
  /// Of the rotor, one step ago. \rtsafe
  [[nodiscard]] double last_position_rad() const noexcept { return last_position_; }
  /// Of the rotor. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return rotor_.velocity; }
  /// Behind the coupling; that of the rotor when it is rigid. \rtsafe
  [[nodiscard]] double load_position_rad() const noexcept { return elastic_ ? load_.position : rotor_.position; }
  /// Behind the coupling; that of the rotor when it is rigid. \rtsafe
  [[nodiscard]] double load_velocity_rad_s() const noexcept { return elastic_ ? load_.velocity : rotor_.velocity; }
  /// Of rotor and load. \rtsafe
  [[nodiscard]] double kinetic_energy_j() const noexcept;
  /// Kinetic energy and what coupling, weight and end stops have stored. \rtsafe
  [[nodiscard]] double energy_j() const noexcept;

 private:
  struct Mass {
    double position = 0.0;
    double velocity = 0.0;
  };
  [[nodiscard]] double with_friction(double velocity, double friction_nm, double inertia) const noexcept;
  [[nodiscard]] double penetration(double position) const noexcept;
  [[nodiscard]] double at_end_stop(const Mass& mass, double velocity, double inertia) const noexcept;
  [[nodiscard]] bool sticks(const Mass& mass, double torque_nm, double friction_nm) const noexcept;
  void step_elastic(double torque_nm, double friction_nm) noexcept;
  void step_rigid(double torque_nm, double friction_nm) noexcept;

  RotorParameters rotor_parameters_;
  LoadParameters load_parameters_;
  double step_s_;
  bool elastic_;
  bool stopped_by_ends_;  ///< there are end stops at all
  double speed_decay_;    ///< of the rotor, left after one step of viscous friction
  double speed_gain_;     ///< of the rotor, per torque in one step
  double load_nm_ = 0.0;
  double blocking_nm_ = 0.0;
  Mass rotor_;
  Mass load_;
  double last_position_ = 0.0;
};

}  // namespace driveline::slaves
