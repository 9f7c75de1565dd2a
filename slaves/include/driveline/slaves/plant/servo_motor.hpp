#pragma once

#include <cstdint>
#include <numbers>
#include <optional>

#include "driveline/slaves/plant/current_loop.hpp"
#include "driveline/slaves/plant/mechanics.hpp"
#include "driveline/slaves/plant/voltage_frequency.hpp"

namespace driveline::slaves {

/// Torque setpoints that the power stage can carry out.
struct TorqueRange {
  double lowest_nm = 0.0;   ///< at most highest_nm
  double highest_nm = 0.0;  ///< below 0 where the back EMF alone drives current: faster than the voltage allows
};

/// A motor with a rigidly coupled load and its encoder. Defaults: one permanent magnet servo of 0.75 kW, wound for the
/// 560 V of rectified 400 V mains (ours). Its data sheet:
///
///   rated point        2.4 Nm x 314 rad/s (3000 rpm) = 754 W; 50 rev/s x 4 pole pairs = 200 Hz
///   torque constant    2.4 Nm / 2.5 A = 0.96 Nm/A effective, 0.679 Nm/A of the amplitude
///   flux, back EMF     0.679 / (1.5 x 4) = 0.113 Vs; x 4 pole pairs: 0.453 V per rad/s, amplitude of a phase:
///                      142 V at 3000 rpm, 284 V at 6000 rpm
///   voltage            560 V / sqrt(3) = 323 V amplitude; 323 / 0.453 = 714 rad/s: 6820 rpm without load
///   winding            at 3.54 A (rated) and 6000 rpm: 3.2 Ohm take 11 V, 10.8 mH x 2513 rad/s take 96 V;
///                      sqrt((284 + 11)^2 + 96^2) = 311 V: rated torque over the whole speed range
///   peak torque        7.2 Nm take 10.6 A: (0.113 w + 34)^2 + (0.115 w)^2 = 323^2 at w = 1856 rad/s electrical,
///                      464 rad/s: 7.2 Nm up to 4430 rpm, then less; 3.1 Nm are left at 6000 rpm
///   losses             1.5 x 3.2 Ohm x (3.54 A)^2 = 60 W of copper, (0.03 + 0.063) Nm x 314 rad/s = 29 W of friction
///                      at the rated point: 754 W of 843 W, 89 %
///
/// The field is not weakened: there is no d current, so the voltage ends the speed.
struct MotorParameters {
  double rated_torque_nm = 2.4;                         ///< continuous torque, which takes the rated current
  double peak_torque_nm = 7.2;                          ///< limit of the torque setpoint, either way
  double rated_current_a = 2.5;                         ///< effective value (not amplitude)
  double inertia_kg_m2 = 3.0e-4;                        ///< motor and load, at the motor shaft
  double viscous_friction_nm_s = 2.0e-4;                ///< Nm per rad/s
  double coulomb_friction_nm = 0.03;                    ///< dry friction of the rotor
  double torque_lag_s = 1.5e-4;                         ///< time constant of the current loop
  double rated_speed_rad_s = 100.0 * std::numbers::pi;  ///< 3000 rev/min; with the pole pairs the rated frequency
  /// 6000 rev/min: what its mechanics are made for. The drive keeps to it (6080h); voltage and load decide how fast the
  /// shaft can turn.
  double max_speed_rad_s = 200.0 * std::numbers::pi;
  std::uint32_t encoder_increments = 1U << 20U;  ///< per revolution, quadrature counted
  double brake_torque_nm = 0.0;                  ///< of the closed holding brake; 0: the motor has none
  std::uint32_t pole_pairs = 4;                  ///< electrical turns per turn of the shaft, 1 to 100
  double encoder_noise_increments = 0.0;         ///< uniform, either way; seeded, so runs repeat bit by bit
  std::uint32_t encoder_seed = 1;                ///< of the noise; 0 counts as 1
  std::uint32_t encoder_turns = kAllTurns;  ///< known after power-on: 0 incremental, 1 single-turn, more multi-turn
  LoadParameters load{};                    ///< load on the shaft
  WindingParameters winding{};              ///< plain lag of the torque, or windings that are simulated

  /// An encoder that counts more turns than any axis makes.
  static constexpr std::uint32_t kAllTurns = 0xFFFFFFFF;

  /// The same motor with every value in the range the model is stable in; NaN becomes the default.
  [[nodiscard]] MotorParameters sanitized() const noexcept;
  /// Rated current of a motor with this rated torque and highest speed that is wound for the voltage of the standard
  /// motor.
  [[nodiscard]] double typical_current_a() const noexcept;
  /// Winding whose voltages are, at rated current and highest speed, the same shares of the back EMF as those of the
  /// standard motor.
  [[nodiscard]] WindingParameters typical_winding() const noexcept;
};

/// Current loop, mechanics and encoder of one axis.
class ServoMotor {
 public:
  /// At rest at `position_rad`; `step_s`: length of every step(), above 0. `parameters` are sanitized().
  ServoMotor(const MotorParameters& parameters, double step_s, double position_rad) noexcept;

  /// One step with this torque setpoint (limited to torque_range(); anything not finite counts as 0). \rtsafe
  void step(double torque_setpoint_nm, bool brake_closed = false) noexcept;
  /// From now on voltages drive the motor, through its windings, also where they are not simulated otherwise; or
  /// torque setpoints again. Torque and speed go on as they are. \rtsafe
  void drive_by_voltage(bool by_voltage) noexcept;
  /// One step with this voltage; its angle counts from where the rotor's d axis is at position 0. \rtsafe
  void step(const VoltageVector& voltage, bool brake_closed) noexcept;
  /// Electrical angle of the rotor. \rtsafe
  [[nodiscard]] double electrical_angle_rad() const noexcept { return parameters_.pole_pairs * position_rad(); }
  /// Amplitude of the phase currents. \rtsafe
  [[nodiscard]] double current_a() const noexcept;
  /// The motor's cables touch each other: no torque but that of the short-circuited windings. \rtsafe
  void set_short_circuit(bool shorted) noexcept;
  /// Without its cable the encoder counts no further. \rtsafe
  void set_encoder_connected(bool connected) noexcept;
  /// A torque on the shaft besides the motor's. \rtsafe
  void set_load(double torque_nm) noexcept { mechanics_.set_load(torque_nm); }
  /// The shaft is stuck, or free again. \rtsafe
  void set_blocked(bool blocked) noexcept { mechanics_.set_blocked(blocked); }
  /// The motor's cables touch each other. \rtsafe
  [[nodiscard]] bool short_circuit() const noexcept { return shorted_; }
  /// The encoder has its cable. \rtsafe
  [[nodiscard]] bool encoder_connected() const noexcept { return encoder_connected_; }
  /// Power taken by shaft and windings; negative: fed back. \rtsafe
  [[nodiscard]] double power_w() const noexcept;
  /// The characteristic of U/f operation that gives 80 % of the rated current at standstill, and rated torque at the
  /// highest speed with no more than rated current.
  [[nodiscard]] VoltageFrequencyParameters rated_characteristic() const noexcept;
  /// Off: the transistors block, setpoints have no effect, the simulated winding is an open circuit; without it the
  /// caller's setpoint is to be 0. On at the start. \rtsafe
  void set_power_stage(bool on) noexcept { power_stage_on_ = on; }
  /// Voltage of the inverter; only the simulated winding needs it. Without any, the power stage is off. \rtsafe
  void set_dc_link_voltage(double volts) noexcept { dc_link_volts_ = volts; }

  /// As they are used: sanitized. \rtsafe
  [[nodiscard]] const MotorParameters& parameters() const noexcept { return parameters_; }
  /// Shaft and load. \rtsafe
  [[nodiscard]] const Mechanics& mechanics() const noexcept { return mechanics_; }
  /// Only runs with a simulated winding. \rtsafe
  [[nodiscard]] const CurrentLoop& current_loop() const noexcept { return current_; }
  /// Of the shaft, not wrapped, without encoder noise. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return mechanics_.position_rad(); }
  [[nodiscard]] double last_position_rad() const noexcept { return mechanics_.last_position_rad(); }  ///< one step ago
  /// Of the shaft. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return mechanics_.velocity_rad_s(); }
  /// Peak torque, reduced where speed and DC link voltage do not allow it. \rtsafe
  [[nodiscard]] TorqueRange torque_range() const noexcept;
  /// Torque of the current loop at the shaft.
  [[nodiscard]] double torque_nm() const noexcept { return torque_nm_; }
  /// Of rotor and load. \rtsafe
  [[nodiscard]] double kinetic_energy_j() const noexcept { return mechanics_.kinetic_energy_j(); }
  /// Position as the encoder counts it, rounded down, with its noise. \rtsafe
  [[nodiscard]] std::int64_t encoder_count() const noexcept {
    return encoder_connected_ ? encoder_count(position_rad()) + noise_ : held_count_;
  }
  /// The count at this position without noise. \rtsafe
  [[nodiscard]] std::int64_t encoder_count(double position_rad) const noexcept;
  /// The count at which an encoder that knows only so many turns would start to count from 0. \rtsafe
  [[nodiscard]] std::int64_t power_on_origin() const noexcept;
  /// Of the encoder. \rtsafe
  [[nodiscard]] double radians_per_increment() const noexcept { return radians_per_increment_; }
  /// Where the last step passed the encoder's index pulse, which comes once per revolution at encoder count 0; the
  /// newest one if a step is longer than a revolution. \rtsafe
  [[nodiscard]] std::optional<std::int64_t> index_pulse() const noexcept {
    return encoder_connected_ ? index_pulse_ : std::nullopt;
  }

 private:
  [[nodiscard]] bool powered() const noexcept { return power_stage_on_ && dc_link_volts_ > 0.0; }
  void draw_noise() noexcept;
  void finish_step(bool brake_closed) noexcept;
  void use_windings(bool before) noexcept;
  void pass_index(double position_rad) noexcept;

  MotorParameters parameters_;
  double torque_constant_;  ///< Nm per ampere of amplitude
  double torque_gain_;      ///< share of the torque error the current loop makes up for in one step
  double radians_per_increment_;
  double increments_per_radian_;
  CurrentLoop current_;
  Mechanics mechanics_;
  bool power_stage_on_ = true;
  double dc_link_volts_ = 560.0;
  double torque_nm_ = 0.0;
  bool by_voltage_ = false;
  bool shorted_ = false;
  bool through_windings_;  ///< the next step's torque comes from the windings
  bool encoder_connected_ = true;
  std::int64_t held_count_ = 0;
  double turn_begin_rad_ = 0.0;  ///< the revolution the shaft is in
  double turn_end_rad_ = 0.0;
  std::optional<std::int64_t> index_pulse_;
  std::int64_t noise_ = 0;
  std::uint32_t random_;
};

}  // namespace driveline::slaves
