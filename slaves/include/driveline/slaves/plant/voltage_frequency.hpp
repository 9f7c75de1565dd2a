#pragma once

namespace driveline::slaves {

/// Characteristic of U/f operation. Voltages are phase amplitudes.
struct VoltageFrequencyParameters {
  double boost_v = 9.0;          ///< voltage at standstill
  double nominal_v = 311.0;      ///< voltage at and above the nominal frequency
  double nominal_hz = 400.0;     ///< electrical, in both directions
  double rated_current_a = 3.5;  ///< amplitude; scales the damping
  double max_current_a = 10.6;   ///< amplitude above which the voltage is reduced
};

/// A voltage in a frame that rotates at the commanded frequency.
struct VoltageVector {
  double in_phase_v = 0.0;    ///< in the direction of the frame
  double quadrature_v = 0.0;  ///< a quarter turn ahead of the frame
  double angle_rad = 0.0;     ///< electrical angle of the frame
};

/// Amplitudes of the motor currents, for the control.
struct PhaseCurrents {
  double amplitude_a = 0.0;  ///< amplitude of the total current
  double active_a = 0.0;     ///< amplitude of the current in phase with the voltage
};

/// Control of frequency and voltage without the rotor's position (U/f operation): the characteristic determines the
/// voltage, its angle is the integral of the frequency. A synchronous motor without damper winding oscillates at higher
/// frequencies; a change of the active current reduces the frequency, which damps this (Perera, Blaabjerg, Pedersen,
/// Thogersen, "A sensorless, stable V/f control method for permanent-magnet synchronous motor drives", IEEE Trans. Ind.
/// Appl. 39(3), 2003). Above the current limit, the voltage is reduced until the current is within the limit.
class VoltageFrequency {
 public:
  /// `step_s`: time between two calls of step().
  explicit VoltageFrequency(double step_s) noexcept : step_s_(step_s) {}

  /// \rtsafe
  void configure(const VoltageFrequencyParameters& parameters) noexcept { parameters_ = parameters; }
  /// Returns the voltage amplitude for a frequency of either sign. \rtsafe
  [[nodiscard]] double characteristic_v(double electrical_rad_s) const noexcept;
  /// Starts with the characteristic's voltage at `angle_rad`; changes to it from `in_force` without a jump. \rtsafe
  void start(const VoltageVector& in_force, double angle_rad, double electrical_rad_s) noexcept;
  /// Runs one step at this frequency and returns its voltage. \rtsafe
  [[nodiscard]] VoltageVector step(double electrical_rad_s, const PhaseCurrents& currents) noexcept;
  /// Whether the current limit reduces the voltage. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return share_ < 1.0; }

 private:
  void limit_current(double amplitude_a) noexcept;

  VoltageFrequencyParameters parameters_;
  double step_s_;
  double angle_rad_ = 0.0;
  double mean_active_a_ = 0.0;
  double share_ = 1.0;  ///< share of the characteristic that the current limit allows
  double start_in_phase_v_ = 0.0;
  double start_quadrature_v_ = 0.0;
  double start_left_ = 0.0;  ///< remaining share of the vector at the start
};

}  // namespace driveline::slaves
