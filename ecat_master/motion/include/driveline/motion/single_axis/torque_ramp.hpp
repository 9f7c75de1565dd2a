#pragma once

namespace driveline::motion {

/// Ramp to the requested torque of an axis under torque control, within a velocity: a torque leads the axis to any
/// velocity, so the ramp reduces it where the axis is about to exceed the permitted one.
///
/// A plain value that allocates no memory; all functions are \rtsafe. Units: Nm or N, rad/s or m/s, rad/s^2 or m/s^2.
class TorqueRamp {
 public:
  /// Limits of the axis.
  struct Limits {
    double max_velocity = 0.0;
    double max_acceleration = 0.0;
    double velocity_gain = 0.0;  ///< torque per deviation of the velocity, Nm s/rad or N s/m
  };

  /// Permits the present velocity of the axis, from which it is braked to that of the request.
  void permit(double velocity) noexcept;
  /// Starts at this torque, with the present velocity of the axis.
  void start(double torque, double velocity) noexcept;
  /// Takes the velocity of an exchange into the measured acceleration. `period_s`: since the previous one.
  void measure(double velocity, double period_s) noexcept;
  /// Continues for one period towards `target`, by at most `step`. `velocity`: permitted by the request. Returns
  /// whether the ramp has reached the target.
  [[nodiscard]] bool advance(double target, double step, double velocity, const Limits& limits,
                             double period_s) noexcept;
  /// Returns the torque of the ramp, reduced so that an axis at `velocity` does not exceed the permitted velocity; a
  /// faster axis is braked no harder than its limits say.
  [[nodiscard]] double torque(double velocity, const Limits& limits) const noexcept;
  /// Whether the axis has exceeded its own velocity limit for longer than its measurement takes. Call once per period.
  [[nodiscard]] bool too_fast(double velocity, const Limits& limits, double period_s) noexcept;
  /// Returns the measured acceleration, filtered.
  [[nodiscard]] double acceleration() const noexcept { return acceleration_; }

 private:
  double torque_ = 0.0;
  double top_ = 0.0;  ///< velocity above which the axis is braked
  double acceleration_ = 0.0;
  double velocity_before_ = 0.0;  ///< velocity of the previous exchange
  double too_fast_s_ = 0.0;
};

}  // namespace driveline::motion
