#pragma once

#include <cstdint>
#include <numbers>
#include <optional>

#include "driveline/slaves/plant/current_loop.hpp"
#include "driveline/slaves/plant/mechanics.hpp"
#include "driveline/slaves/plant/voltage_frequency.hpp"

namespace driveline::slaves {

/// Range of torque setpoints that the power stage can realise.
struct TorqueRange {
  double lowest_nm = 0.0;   ///< at most highest_nm
  double highest_nm = 0.0;  ///< below 0 when the back EMF alone drives current: faster than the voltage allows
};

/// A motor with its load and encoder. Defaults: a permanent magnet servo motor of 0.75 kW, wound for the 560 V of
/// rectified 400 V mains (ours). Its data sheet:
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
/// There is no field weakening (no d current), so the voltage limits the speed.
struct MotorParameters {
  double rated_torque_nm = 2.4;                         ///< continuous torque, at the rated current
  double peak_torque_nm = 7.2;                          ///< limit of the torque setpoint in both directions
  double rated_current_a = 2.5;                         ///< RMS value (not amplitude)
  double inertia_kg_m2 = 3.0e-4;                        ///< motor and load, at the motor shaft
  double viscous_friction_nm_s = 2.0e-4;                ///< Nm per rad/s
  double coulomb_friction_nm = 0.03;                    ///< dry friction of the rotor
  double torque_lag_s = 1.5e-4;                         ///< time constant of the current loop
  double rated_speed_rad_s = 100.0 * std::numbers::pi;  ///< 3000 rev/min; determines the rated frequency
  /// 6000 rev/min: mechanical limit. The drive observes it (6080h); voltage and load limit the actual speed.
  double max_speed_rad_s = 200.0 * std::numbers::pi;
  std::uint32_t encoder_increments = 1U << 20U;  ///< per revolution, quadrature counted
  double brake_torque_nm = 0.0;                  ///< torque of the closed holding brake; 0: no brake
  std::uint32_t pole_pairs = 4;                  ///< electrical turns per turn of the shaft, 1 to 100
  double encoder_noise_increments = 0.0;         ///< uniform, in both directions; seeded, so that runs are reproducible
  std::uint32_t encoder_seed = 1;                ///< seed of the noise; 0 counts as 1
  std::uint32_t encoder_turns = kAllTurns;  ///< known after power-on: 0 incremental, 1 single-turn, more multi-turn
  LoadParameters load{};                    ///< load on the shaft
  WindingParameters winding{};              ///< simulated windings, or a plain lag of the torque

  /// Number of turns that no axis exceeds.
  static constexpr std::uint32_t kAllTurns = 0xFFFFFFFF;

  /// Returns the same motor with every value limited to the range where the model is stable; NaN becomes the default.
  [[nodiscard]] MotorParameters sanitized() const noexcept;
  /// Returns the rated current of a motor with this rated torque and maximum speed that is wound for the same voltage
  /// as the default motor.
  [[nodiscard]] double typical_current_a() const noexcept;
  /// Returns the winding whose voltage drops at rated current and maximum speed are the same shares of the back EMF as
  /// in the default motor.
  [[nodiscard]] WindingParameters typical_winding() const noexcept;
};

/// Current loop, mechanics and encoder of an axis.
class ServoMotor {
 public:
  /// Starts at rest at `position_rad`; `step_s`: length of every step(), above 0. `parameters` are sanitized().
  ServoMotor(const MotorParameters& parameters, double step_s, double position_rad) noexcept;

  /// Runs one step with this torque setpoint, limited to torque_range(); a non-finite value counts as 0. \rtsafe
  void step(double torque_setpoint_nm, bool brake_closed = false) noexcept {
    step(torque_setpoint_nm, torque_range(), brake_closed);
  }
  /// The same for a caller that has torque_range() of this step already. \rtsafe
  void step(double torque_setpoint_nm, const TorqueRange& range, bool brake_closed) noexcept;
  /// Selects voltages (true) or torque setpoints (false) as the input. Voltages act on the windings even if these are
  /// not simulated otherwise. Torque and speed continue without a jump. \rtsafe
  void drive_by_voltage(bool by_voltage) noexcept;
  /// Runs one step with this voltage; its angle is relative to the rotor's d axis at position 0. \rtsafe
  void step(const VoltageVector& voltage, bool brake_closed) noexcept;
  /// Returns the electrical angle of the rotor. \rtsafe
  [[nodiscard]] double electrical_angle_rad() const noexcept { return parameters_.pole_pairs * position_rad(); }
  /// Returns the amplitude of the phase currents. \rtsafe
  [[nodiscard]] double current_a() const noexcept;
  /// Sets or removes a short circuit of the motor cables: only the short-circuited windings produce torque. \rtsafe
  void set_short_circuit(bool shorted) noexcept;
  /// Connects or disconnects the encoder; a disconnected encoder holds its count. \rtsafe
  void set_encoder_connected(bool connected) noexcept;
  /// Sets an additional torque on the shaft, see Mechanics::set_load(). \rtsafe
  void set_load(double torque_nm) noexcept { mechanics_.set_load(torque_nm); }
  /// Blocks or releases the shaft. \rtsafe
  void set_blocked(bool blocked) noexcept { mechanics_.set_blocked(blocked); }
  /// Whether the motor cables are short-circuited. \rtsafe
  [[nodiscard]] bool short_circuit() const noexcept { return shorted_; }
  /// Whether the encoder is connected. \rtsafe
  [[nodiscard]] bool encoder_connected() const noexcept { return encoder_connected_; }
  /// Returns the power consumed by shaft and windings; negative: regenerative. \rtsafe
  [[nodiscard]] double power_w() const noexcept;
  /// Returns the U/f characteristic with 80 % of the rated current at standstill, and rated torque at the maximum speed
  /// with no more than rated current.
  [[nodiscard]] VoltageFrequencyParameters rated_characteristic() const noexcept;
  /// Switches the power stage. Off: the transistors block and setpoints have no effect; simulated windings are an open
  /// circuit, otherwise the torque decays with its lag. On at the start. \rtsafe
  void set_power_stage(bool on) noexcept { power_stage_on_ = on; }
  /// Sets the DC link voltage of the inverter, which limits torque_range(). At 0 the power stage is off. \rtsafe
  void set_dc_link_voltage(double volts) noexcept { dc_link_volts_ = volts; }

  /// Returns the parameters in use: sanitized. \rtsafe
  [[nodiscard]] const MotorParameters& parameters() const noexcept { return parameters_; }
  /// Returns the model of shaft and load. \rtsafe
  [[nodiscard]] const Mechanics& mechanics() const noexcept { return mechanics_; }
  /// Returns the current loop; it runs only while the torque comes from the windings. \rtsafe
  [[nodiscard]] const CurrentLoop& current_loop() const noexcept { return current_; }
  /// Returns the position of the shaft, not wrapped, without encoder noise. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return mechanics_.position_rad(); }
  [[nodiscard]] double last_position_rad() const noexcept { return mechanics_.last_position_rad(); }  ///< one step ago
  /// Returns the velocity of the shaft. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return mechanics_.velocity_rad_s(); }
  /// Returns the range up to the peak torque, reduced where speed and DC link voltage do not allow it. \rtsafe
  [[nodiscard]] TorqueRange torque_range() const noexcept {
    const double peak = parameters_.peak_torque_nm;
    if (current_.surely_holds(peak_current_, mechanics_.velocity_rad_s(), dc_link_volts_)) return {-peak, peak};
    return reduced_torque_range();
  }
  /// Returns the torque of the current loop at the shaft.
  [[nodiscard]] double torque_nm() const noexcept { return torque_nm_; }
  /// Returns the kinetic energy of rotor and load. \rtsafe
  [[nodiscard]] double kinetic_energy_j() const noexcept { return mechanics_.kinetic_energy_j(); }
  /// Returns the count of the encoder, rounded down, with its noise. \rtsafe
  [[nodiscard]] std::int64_t encoder_count() const noexcept {
    return encoder_connected_ ? count_ + noise_ : held_count_;
  }
  /// Returns the count at this position, without noise. \rtsafe
  [[nodiscard]] std::int64_t encoder_count(double position_rad) const noexcept {
    // Rounds down without a call of floor(), which x86-64 has no instruction for.
    const double increments = position_rad * increments_per_radian_;
    const auto towards_zero = static_cast<std::int64_t>(increments);
    return towards_zero - (increments < static_cast<double>(towards_zero) ? 1 : 0);
  }
  /// Returns the count that is 0 after power-on for an encoder that knows only `encoder_turns` turns. \rtsafe
  [[nodiscard]] std::int64_t power_on_origin() const noexcept;
  /// Returns the resolution of the encoder. \rtsafe
  [[nodiscard]] double radians_per_increment() const noexcept { return radians_per_increment_; }
  /// Returns the count where the last step passed the encoder's index pulse, which occurs once per revolution at
  /// encoder count 0; the last one if a step is longer than a revolution. \rtsafe
  [[nodiscard]] std::optional<std::int64_t> index_pulse() const noexcept {
    return passed_index() ? std::optional(index_count_) : std::nullopt;
  }
  /// Whether index_pulse() has a value. \rtsafe
  [[nodiscard]] bool passed_index() const noexcept { return encoder_connected_ && passed_index_; }

 private:
  [[nodiscard]] bool powered() const noexcept { return power_stage_on_ && dc_link_volts_ > 0.0; }
  [[nodiscard]] TorqueRange reduced_torque_range() const noexcept;
  void draw_noise() noexcept;
  void finish_step(bool brake_closed) noexcept;
  void use_windings(bool before) noexcept;
  void pass_index(double position_rad) noexcept;

  MotorParameters parameters_;
  double torque_constant_;  ///< Nm per ampere of current amplitude
  double torque_gain_;      ///< share of the torque error that the current loop corrects in one step
  double radians_per_increment_;
  double increments_per_radian_;
  CurrentLoop current_;
  CurrentLoop::Holding peak_current_;  ///< current for the peak torque
  Mechanics mechanics_;
  bool power_stage_on_ = true;
  double dc_link_volts_ = 560.0;
  double torque_nm_ = 0.0;
  bool by_voltage_ = false;
  bool shorted_ = false;
  bool through_windings_;  ///< the windings determine the torque of the next step
  bool encoder_connected_ = true;
  std::int64_t count_ = 0;  ///< encoder count without noise, cached: read often in every step
  std::int64_t held_count_ = 0;
  double turn_begin_rad_ = 0.0;  ///< start of the present revolution of the shaft
  double turn_end_rad_ = 0.0;
  std::int64_t index_count_ = 0;  ///< count of the index pulse that was passed last
  bool passed_index_ = false;     ///< in the last step
  std::int64_t noise_ = 0;
  std::uint32_t random_;
};

}  // namespace driveline::slaves
