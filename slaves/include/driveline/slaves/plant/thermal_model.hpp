#pragma once

namespace driveline::slaves {

/// Parameters of the temperatures of motor and power stage, each a first-order lag of the squared current.
struct ThermalParameters {
  double motor_time_constant_s = 600.0;      ///< time constant of the windings
  double motor_rise_k = 65.0;                ///< temperature rise at rated current
  double amplifier_time_constant_s = 120.0;  ///< time constant of the power stage
  double amplifier_rise_k = 30.0;            ///< temperature rise at rated current
  double ambient_c = 25.0;                   ///< temperature of motor and power stage after a long time without current
};

/// Parameters of the I2t monitoring (P 735).
struct OverloadLimits {
  bool thermal = true;            ///< THERM: share of the rated thermal load; false: FREQ
  double time_constant_s = 60.0;  ///< THERM (P 733[7])
  double rated = 1.0;             ///< FREQ: permitted current at and above `rated_hz`, in rated currents (P 733[0])
  double standstill = 1.0;        ///< permitted current at 0 Hz (P 733[1])
  double middle = 1.0;            ///< permitted current at `middle_hz` (P 733[2], [3])
  double middle_hz = 10.0;        ///< up to here the limit goes from `standstill` to `middle`, then to `rated`
  double rated_hz = 50.0;         ///< from here on the limit is `rated`
  double rated_share = 1.0;       ///< rated current of the monitoring (P 457), as a share of the motor's
};

/// Temperatures of motor and power stage, two masses heated by the squared current, and overload monitoring.
class ThermalModel {
 public:
  /// Starts cold: at ambient temperature, integrator at 0. Impossible values become the nearest possible ones.
  explicit ThermalModel(const ThermalParameters& parameters = {}) noexcept;

  /// Runs a step of `step_s` with this current, in rated currents, at this electrical frequency. \rtsafe
  void step(double current, double frequency_hz, const OverloadLimits& limits, double step_s) noexcept;
  /// Resets to the state after a long time without current. \rtsafe
  void reset() noexcept;

  /// Sets the ambient temperature; motor and power stage follow with their time constants. \rtsafe
  void set_ambient(double celsius) noexcept;
  /// Returns the ambient temperature in degrees Celsius. \rtsafe
  [[nodiscard]] double ambient_c() const noexcept { return parameters_.ambient_c; }

  /// Returns the integrator in percent: THERM 100 % after a long time at rated current, trips at 110 %; FREQ 100 % is
  /// the trip point, 150 % of the permitted current for 120 s (Device Help). \rtsafe
  [[nodiscard]] double overload_percent() const noexcept { return overload_percent_; }
  /// Returns the temperature of the windings in degrees Celsius. \rtsafe
  [[nodiscard]] double motor_c() const noexcept { return motor_c_; }
  /// Returns the temperature of the power stage in degrees Celsius. \rtsafe
  [[nodiscard]] double amplifier_c() const noexcept { return amplifier_c_; }

 private:
  ThermalParameters parameters_;
  double overload_percent_ = 0.0;
  double motor_c_ = 0.0;
  double amplifier_c_ = 0.0;
};

}  // namespace driveline::slaves
