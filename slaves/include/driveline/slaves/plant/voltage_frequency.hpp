#pragma once

namespace driveline::slaves {

/// The characteristic of U/f operation. Voltages are amplitudes of a phase.
struct VoltageFrequencyParameters {
  double boost_v = 9.0;          ///< at standstill
  double nominal_v = 311.0;      ///< at the nominal frequency; above it the voltage stays
  double nominal_hz = 400.0;     ///< electrical, of either direction
  double rated_current_a = 3.5;  ///< amplitude; scales the damping
  double max_current_a = 10.6;   ///< amplitude the voltage gives way at
};

/// A voltage in a frame that turns with the commanded frequency; `angle_rad` is that of the frame, electrical.
struct VoltageVector {
  double in_phase_v = 0.0;    ///< along the frame
  double quadrature_v = 0.0;  ///< a quarter turn ahead of it
  double angle_rad = 0.0;     ///< of the frame
};

/// Motor currents for the control: amplitudes.
struct PhaseCurrents {
  double amplitude_a = 0.0;  ///< of the whole current
  double active_a = 0.0;     ///< in phase with the voltage
};

/// Control of frequency and voltage without the rotor's position (U/f operation): voltage by the characteristic, its
/// angle the integral of the frequency. A synchronous motor without damper winding swings at higher frequencies; a
/// change of the active current lowers the frequency, which damps it (Perera, Blaabjerg, Pedersen, Thogersen, "A
/// sensorless, stable V/f control method for permanent-magnet synchronous motor drives", IEEE Trans. Ind. Appl. 39(3),
/// 2003). Above the current limit the voltage gives way until the current is back.
class VoltageFrequency {
 public:
  /// `step_s`: time between two calls of step().
  explicit VoltageFrequency(double step_s) noexcept : step_s_(step_s) {}

  /// \rtsafe
  void configure(const VoltageFrequencyParameters& parameters) noexcept { parameters_ = parameters; }
  /// Amplitude for a frequency of either sign. \rtsafe
  [[nodiscard]] double characteristic_v(double electrical_rad_s) const noexcept;
  /// Begins with the characteristic's voltage at `angle_rad`; the vector changes to it from the one in force, without a
  /// jump. \rtsafe
  void start(const VoltageVector& in_force, double angle_rad, double electrical_rad_s) noexcept;
  /// One step at this frequency; the voltage for it. \rtsafe
  [[nodiscard]] VoltageVector step(double electrical_rad_s, const PhaseCurrents& currents) noexcept;
  /// The current limit has taken voltage away. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return share_ < 1.0; }

 private:
  void limit_current(double amplitude_a) noexcept;

  VoltageFrequencyParameters parameters_;
  double step_s_;
  double angle_rad_ = 0.0;
  double mean_active_a_ = 0.0;
  double share_ = 1.0;  ///< of the characteristic, left by the current limit
  double start_in_phase_v_ = 0.0;
  double start_quadrature_v_ = 0.0;
  double start_left_ = 0.0;  ///< share of the vector in force at the start
};

}  // namespace driveline::slaves
