#pragma once

#include <limits>

namespace driveline::slaves {

/// The load, referred to the motor shaft.
struct LoadParameters {
  double inertia_kg_m2 = 0.0;        ///< inertia behind an elastic coupling; 0: rigid load, part of the motor's inertia
  double stiffness_nm_rad = 200.0;   ///< stiffness of the coupling
  double damping_nm_s = 0.01;        ///< damping of the coupling
  double coulomb_friction_nm = 0.0;  ///< dry friction of the load; 0 or more
  double gravity_nm = 0.0;           ///< torque of a weight, acts in negative direction
  /// Load position at the lower end stop; infinite: none
  double end_stop_min_rad = -std::numeric_limits<double>::infinity();
  /// Load position at the upper end stop; infinite: none. Unless lower < upper, there are no end stops
  double end_stop_max_rad = std::numeric_limits<double>::infinity();
  double end_stop_stiffness_nm_rad = 500.0;  ///< stiffness of either end stop
  double end_stop_damping_nm_s = 0.05;       ///< Nm per rad/s, of either end stop; dissipates energy, never pulls

  /// Returns the same load with every value limited to the range where the model is stable. \rtsafe
  [[nodiscard]] LoadParameters sanitized() const noexcept;
};

/// Inertia and friction of the motor.
struct RotorParameters {
  double inertia_kg_m2 = 3.0e-4;          ///< at the shaft; above 0
  double viscous_friction_nm_s = 2.0e-4;  ///< Nm per rad/s
  double coulomb_friction_nm = 0.03;      ///< dry friction
  double brake_torque_nm = 0.0;           ///< torque of the closed holding brake; 0: none
};

/// One or two masses with friction, brake, gravity and end stops. The coupling is integrated by the implicit midpoint
/// rule, which preserves its energy exactly, and all dissipation is integrated implicitly: without torque the model
/// never gains energy, for any step length and parameters. An end stop that is too stiff for the step length may store
/// more energy for a moment than the impact had, but does not return it.
class Mechanics {
 public:
  /// Starts at rest at `position_rad`. `step_s`: length of every step(), above 0.
  Mechanics(const RotorParameters& rotor, const LoadParameters& load, double step_s, double position_rad) noexcept;

  /// Runs one step with this torque at the rotor. \rtsafe
  void step(double torque_nm, bool brake_closed) noexcept;
  /// Sets an additional torque at the rotor, like that of a weight: positive pulls in negative direction. \rtsafe
  void set_load(double torque_nm) noexcept;
  /// Blocks or releases the rotor. \rtsafe
  void set_blocked(bool blocked) noexcept;
  /// Returns the torque of set_load(). \rtsafe
  [[nodiscard]] double load_nm() const noexcept { return load_nm_; }
  /// Whether the rotor is blocked. \rtsafe
  [[nodiscard]] bool blocked() const noexcept { return blocking_nm_ > 0.0; }

  /// Returns the position of the rotor, not wrapped. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return rotor_.position; }
  /// Returns the position of the rotor one step ago. \rtsafe
  [[nodiscard]] double last_position_rad() const noexcept { return last_position_; }
  /// Returns the velocity of the rotor. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return rotor_.velocity; }
  /// Returns the position behind the coupling; the rotor's position when the coupling is rigid. \rtsafe
  [[nodiscard]] double load_position_rad() const noexcept { return elastic_ ? load_.position : rotor_.position; }
  /// Returns the velocity behind the coupling; the rotor's velocity when the coupling is rigid. \rtsafe
  [[nodiscard]] double load_velocity_rad_s() const noexcept { return elastic_ ? load_.velocity : rotor_.velocity; }
  /// Returns the kinetic energy of rotor and load. \rtsafe
  [[nodiscard]] double kinetic_energy_j() const noexcept;
  /// Returns the kinetic energy plus the potential energy of coupling, weight and end stops. \rtsafe
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
  bool stopped_by_ends_;  ///< the load has at least one end stop
  double speed_decay_;    ///< share of the rotor speed left after one step of viscous friction
  double speed_gain_;     ///< change of the rotor speed per torque in one step
  double load_nm_ = 0.0;
  double blocking_nm_ = 0.0;
  Mass rotor_;
  Mass load_;
  double last_position_ = 0.0;
};

}  // namespace driveline::slaves
