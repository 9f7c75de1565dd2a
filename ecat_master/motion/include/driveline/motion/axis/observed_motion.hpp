#pragma once

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Estimates position, velocity and acceleration of an axis from its quantised positions, in any mode of its drive: a
/// fading-memory filter of third order. Where the torques of the axis are commanded and its inertia is known, it adds
/// their effect, which the positions do not show yet.
///
/// A plain value that allocates no memory; all functions are \rtsafe.
class ObservedMotion {
 public:
  /// Memory factor of the filter per cycle.
  static constexpr double kMemory = 0.75;

  ObservedMotion() = default;
  /// `period_s`: time between two cycles, s. `inertia`: kg m^2 or kg; 0: not known.
  ObservedMotion(double period_s, double inertia) noexcept : period_s_(period_s), inertia_(inertia) {}

  /// Starts with this motion, and with `torque` as commanded for several cycles, Nm or N.
  void start(const trajectory::AxisSetpoint& motion, double torque) noexcept;
  /// Moves the estimate back by one period: the next observe() gets the position at which it was started.
  void step_back() noexcept { motion_.position -= motion_.velocity * period_s_; }
  /// Estimates the motion of the next cycle without a measurement.
  void predict() noexcept { pass(period_s_); }
  /// Corrects the prediction by the measured position, rad or m.
  void correct(double position) noexcept;
  /// Continues the motion for `time_s` without cycles.
  void pass(double time_s) noexcept;
  /// The axis continues at its velocity.
  void coast() noexcept { motion_.acceleration = 0.0; }
  /// Commands a torque for this cycle, Nm or N; earlier ones take effect.
  void command(double torque) noexcept;
  /// The torque of the last cycle was not sent; earlier ones still take effect.
  void hold_torque() noexcept;

  /// Returns the estimated motion; rad or m, and its derivatives.
  [[nodiscard]] const trajectory::AxisSetpoint& motion() const noexcept { return motion_; }
  /// Returns the acceleration after all commanded torques have taken effect, rad/s^2 or m/s^2.
  [[nodiscard]] double coming_acceleration() const noexcept { return motion_.acceleration + on_its_way_; }

 private:
  double period_s_ = 125e-6;
  double inertia_ = 0.0;
  trajectory::AxisSetpoint motion_{};
  double on_its_way_ = 0.0;   ///< acceleration that the torques commanded last will add
  double commanded_[4] = {};  ///< torques commanded in the last cycles, newest first
};

}  // namespace driveline::motion
