#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// A motor with a rigidly coupled load and its encoder. Defaults: a small permanent magnet servo of 0.75 kW (ours).
struct MotorParameters {
  double rated_torque_nm = 2.4;
  double peak_torque_nm = 7.2;
  double rated_current_a = 4.1;
  double inertia_kg_m2 = 3.0e-4;          ///< motor and load, at the motor shaft
  double viscous_friction_nm_s = 2.0e-4;  ///< Nm per rad/s
  double coulomb_friction_nm = 0.03;
  double torque_lag_s = 1.5e-4;                  ///< time constant of the current loop
  double max_speed_rad_s = 628.0;                ///< mechanical limit: 6000 rev/min
  std::uint32_t encoder_increments = 1U << 20U;  ///< per revolution, quadrature counted
  double brake_torque_nm = 0.0;                  ///< of the closed holding brake; 0: the motor has none
  std::uint32_t pole_pairs = 4;

  /// The same motor with every value in the range the model is stable in; NaN becomes the default.
  [[nodiscard]] MotorParameters sanitized() const noexcept;
};

/// Mechanics and current loop of one axis, integrated exactly for constant torque over a step, friction implicit: the
/// model cannot gain energy without torque and is stable for every step length and parameter set.
class ServoMotor {
 public:
  ServoMotor(const MotorParameters& parameters, double step_s, double position_rad) noexcept;

  /// One step with this torque setpoint (limited to the peak torque; anything not finite counts as 0). \rtsafe
  void step(double torque_setpoint_nm, bool brake_closed = false) noexcept;

  [[nodiscard]] const MotorParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] double position_rad() const noexcept { return position_rad_; }
  [[nodiscard]] double last_position_rad() const noexcept { return last_position_rad_; }  ///< one step ago
  [[nodiscard]] double velocity_rad_s() const noexcept { return velocity_rad_s_; }
  /// Torque of the current loop at the shaft.
  [[nodiscard]] double torque_nm() const noexcept { return torque_nm_; }
  [[nodiscard]] double kinetic_energy_j() const noexcept {
    return 0.5 * parameters_.inertia_kg_m2 * velocity_rad_s_ * velocity_rad_s_;
  }
  /// Position as the encoder counts it, rounded down. \rtsafe
  [[nodiscard]] std::int64_t encoder_count() const noexcept { return encoder_count(position_rad_); }
  [[nodiscard]] std::int64_t encoder_count(double position_rad) const noexcept;
  [[nodiscard]] double radians_per_increment() const noexcept { return radians_per_increment_; }
  /// Where the last step passed the encoder's index pulse, which comes once per revolution at encoder count 0; the
  /// newest one if a step is longer than a revolution. \rtsafe
  [[nodiscard]] std::optional<std::int64_t> index_pulse() const noexcept;

 private:
  MotorParameters parameters_;
  double step_s_;
  double torque_gain_;  ///< share of the torque error the current loop makes up for in one step
  double speed_decay_;  ///< speed left after one step of viscous friction
  double speed_gain_;   ///< speed per torque in one step
  double radians_per_increment_;
  double increments_per_radian_;
  double position_rad_;
  double last_position_rad_;  ///< one step ago
  double velocity_rad_s_ = 0.0;
  double torque_nm_ = 0.0;
};

}  // namespace driveline::slaves
