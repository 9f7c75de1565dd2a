#pragma once

#include <cmath>
#include <numbers>

namespace driveline::slaves {

/// Windings of a permanent magnet motor with surface magnets. Currents are amplitudes.
struct WindingParameters {
  bool simulated = false;             ///< false: the torque follows its setpoint as a first-order lag
  double resistance_ohm = 3.2;        ///< per phase; at least 1e-6
  double inductance_h = 10.8e-3;      ///< per phase; at least 1e-7
  double saturation_current_a = 0.0;  ///< amplitude at which the torque constant is 30 % lower; 0: no saturation
};

/// Range of the q current amplitude, lowest <= highest.
struct CurrentRange {
  double lowest_a = 0.0;   ///< limit in negative direction
  double highest_a = 0.0;  ///< limit in positive direction
};

/// Current control in the d and q axes of the rotor: PI controllers with decoupling, the voltage limit of the inverter,
/// and windings with resistance, inductance, back EMF and iron saturation.
class CurrentLoop {
 public:
  /// `torque_constant`: Nm per ampere of q current; `lag_s`: time constant of the closed loop.
  CurrentLoop(const WindingParameters& parameters, double torque_constant, unsigned pole_pairs, double lag_s,
              double step_s) noexcept;

  /// Runs one step at this shaft speed and DC link voltage; returns the torque at its end. \rtsafe
  double step(double torque_setpoint_nm, double speed_rad_s, double dc_link_volts) noexcept;

  /// Runs one step with a voltage in the rotor's axes instead of current control. \rtsafe
  double step_voltage(double d_v, double q_v, double speed_rad_s, double dc_link_volts) noexcept;
  /// Sets currents and voltages to their steady state at this torque and speed, without d current. \rtsafe
  void settle(double torque_nm, double speed_rad_s) noexcept;
  /// Resumes current control with the voltage for the present currents. \rtsafe
  void resume() noexcept;
  /// Returns the angle from the d axis to a voltage of this amplitude that in steady state produces this torque at this
  /// speed, or the greatest torque that it can produce if that is less. Of two solutions, returns the one where the
  /// torque increases with the angle. \rtsafe
  [[nodiscard]] double voltage_angle_rad(double amplitude_v, double torque_nm, double speed_rad_s) const noexcept;

  /// Returns the q currents, without d current, that are possible in steady state at this speed and DC link voltage; if
  /// none is, the current that needs the least voltage. \rtsafe
  [[nodiscard]] CurrentRange holdable(double speed_rad_s, double dc_link_volts) const noexcept;
  /// A q current with what a quick check needs of it.
  struct Holding {
    double per_speed_vs = 0.0;  ///< voltage per electrical speed: back EMF and reactance
    double resistive_v = 0.0;   ///< voltage at standstill
  };
  /// Returns this for surely_holds().
  [[nodiscard]] Holding holding(double current_a) const noexcept {
    return {flux_vs_ + parameters_.inductance_h * current_a, parameters_.resistance_ohm * current_a};
  }
  /// Quick sufficient check that the voltage allows this q current in either direction. \rtsafe
  [[nodiscard]] bool surely_holds(const Holding& current, double speed_rad_s, double dc_link_volts) const noexcept {
    const double speed = pole_pairs_ * std::abs(speed_rad_s);
    const double volts = speed * current.per_speed_vs + current.resistive_v;
    return volts * std::numbers::sqrt3 <= dc_link_volts;
  }

  /// Returns the d voltage of the last step. \rtsafe
  [[nodiscard]] double d_voltage_v() const noexcept { return d_v_; }
  /// Returns the q voltage of the last step.
  [[nodiscard]] double q_voltage_v() const noexcept { return q_v_; }
  /// Returns the amplitude of the current. \rtsafe
  [[nodiscard]] double current_a() const noexcept { return std::hypot(d_a_, q_a_); }
  /// Returns the part of the current in phase with the voltage. \rtsafe
  [[nodiscard]] double active_current_a() const noexcept;
  /// Returns the current in the direction of the magnets' flux; it produces no torque. \rtsafe
  [[nodiscard]] double d_current_a() const noexcept { return d_a_; }
  /// Returns the current across the magnets' flux; it produces the torque. \rtsafe
  [[nodiscard]] double q_current_a() const noexcept { return q_a_; }
  /// Replaces step() while the transistors are blocked: no current, no torque. \rtsafe
  void open_circuit() noexcept;
  /// Whether the inverter's limit cut the voltage in the last step. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  /// Returns the heat power in the windings. \rtsafe
  [[nodiscard]] double loss_w() const noexcept;
  /// Returns the power from the inverter in the last step. \rtsafe
  [[nodiscard]] double power_w() const noexcept { return 1.5 * (d_v_ * d_a_ + q_v_ * q_a_); }
  /// Returns the energy in the magnetic field of the windings. \rtsafe
  [[nodiscard]] double energy_j() const noexcept {
    return 0.75 * parameters_.inductance_h * (d_a_ * d_a_ + q_a_ * q_a_);
  }

 private:
  [[nodiscard]] double torque_nm() const noexcept;
  /// Applies a voltage, limited to that of the inverter; returns whether it was limited.
  bool drive_windings(double d_v, double q_v, double electrical_rad_s, double dc_link_volts) noexcept;

  WindingParameters parameters_;
  double torque_constant_;
  double flux_vs_;
  double pole_pairs_;
  double step_s_;
  double proportional_v_a_;
  double integral_v_a_;  ///< per step
  double d_a_ = 0.0;
  double q_a_ = 0.0;
  double d_v_ = 0.0;
  double q_v_ = 0.0;
  double d_integral_v_ = 0.0;
  double q_integral_v_ = 0.0;
  bool limited_ = false;
};

}  // namespace driveline::slaves
