#pragma once

#include <cmath>

namespace driveline::slaves {

/// Windings of a permanent magnet motor with surface magnets, and its current control. Currents are amplitudes.
struct WindingParameters {
  bool simulated = false;             ///< false: the torque follows its setpoint as a first-order lag
  double resistance_ohm = 3.2;        ///< of one phase; at least 1e-6
  double inductance_h = 10.8e-3;      ///< of one phase; at least 1e-7
  double saturation_current_a = 0.0;  ///< amplitude at which the torque constant has fallen by 30 %; 0: none
};

/// Amplitudes of q current, lowest <= highest.
struct CurrentRange {
  double lowest_a = 0.0;   ///< most in negative direction
  double highest_a = 0.0;  ///< most in positive direction
};

/// Current control in the rotor's d and q axes: PI controllers with decoupling, the voltage limit of the inverter,
/// windings with resistance, inductance, back EMF and iron saturation.
class CurrentLoop {
 public:
  /// `torque_constant`: Nm per ampere of q current; `lag_s`: time constant of the closed loop.
  CurrentLoop(const WindingParameters& parameters, double torque_constant, unsigned pole_pairs, double lag_s,
              double step_s) noexcept;

  /// One step at this speed of the shaft with this DC link voltage; the torque at its end. \rtsafe
  double step(double torque_setpoint_nm, double speed_rad_s, double dc_link_volts) noexcept;

  /// The same with a voltage in the rotor's axes instead of current control. \rtsafe
  double step_voltage(double d_v, double q_v, double speed_rad_s, double dc_link_volts) noexcept;
  /// Currents and voltages as they have settled with this torque at this speed, without d current. \rtsafe
  void settle(double torque_nm, double speed_rad_s) noexcept;
  /// Resumes current control with the voltage for the present currents. \rtsafe
  void resume() noexcept;
  /// Angle between d axis and a voltage of this amplitude that has settled to this torque at this speed; with the
  /// most it can do, if that is less. The branch where more angle is more torque. \rtsafe
  [[nodiscard]] double voltage_angle_rad(double amplitude_v, double torque_nm, double speed_rad_s) const noexcept;

  /// The q currents, without d current, that this DC link voltage can hold at this speed; where it can hold none, the
  /// one that needs the least. \rtsafe
  [[nodiscard]] CurrentRange holdable(double speed_rad_s, double dc_link_volts) const noexcept;
  /// A quick sufficient check that the voltage is enough for this q current of either sign. \rtsafe
  [[nodiscard]] bool surely_holds(double current_a, double speed_rad_s, double dc_link_volts) const noexcept;

  /// Voltages of the last step in the rotor's axes. \rtsafe
  [[nodiscard]] double d_voltage_v() const noexcept { return d_v_; }
  /// See d_voltage_v().
  [[nodiscard]] double q_voltage_v() const noexcept { return q_v_; }
  /// Amplitude. \rtsafe
  [[nodiscard]] double current_a() const noexcept { return std::hypot(d_a_, q_a_); }
  /// The part of the current in phase with the voltage. \rtsafe
  [[nodiscard]] double active_current_a() const noexcept;
  /// In the direction of the magnets' flux; makes no torque. \rtsafe
  [[nodiscard]] double d_current_a() const noexcept { return d_a_; }
  /// Across the magnets' flux; makes the torque. \rtsafe
  [[nodiscard]] double q_current_a() const noexcept { return q_a_; }
  /// One step with blocked transistors, instead of step(): no current, no torque. \rtsafe
  void open_circuit() noexcept;
  /// The voltage was at the inverter's limit in the last step. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  /// Heat in the windings. \rtsafe
  [[nodiscard]] double loss_w() const noexcept;
  /// Power from the inverter in the last step. \rtsafe
  [[nodiscard]] double power_w() const noexcept { return 1.5 * (d_v_ * d_a_ + q_v_ * q_a_); }
  /// In the field of the windings. \rtsafe
  [[nodiscard]] double energy_j() const noexcept {
    return 0.75 * parameters_.inductance_h * (d_a_ * d_a_ + q_a_ * q_a_);
  }

 private:
  [[nodiscard]] double torque_nm() const noexcept;
  /// Applies a voltage, cut to what the inverter has; true: it was cut.
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
