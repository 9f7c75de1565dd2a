#pragma once

#include <limits>
#include <numbers>

namespace driveline::slaves {

/// Gains of the cascade: position P, velocity PI, torque. The defaults suit the default motor (ours): velocity loop by
/// the symmetrical optimum over torque lag and speed filter, position loop much slower.
struct ControllerParameters {
  double position_gain_per_s = 150.0;  ///< rad/s per rad of position error
  double velocity_gain_nm_s = 0.25;    ///< Nm per rad/s
  double velocity_reset_s = 3.0e-3;    ///< integral time; 0 or less: no integral part
  double velocity_filter_s = 3.0e-4;   ///< low pass of the measured speed and, to match it, of the speed feed-forward
  double max_velocity_rad_s = 200.0 * std::numbers::pi;  ///< limit of the velocity setpoint in both directions
  double max_torque_nm = 7.2;                            ///< limit of the torque setpoint in both directions

  /// Returns the same gains with negative values set to 0; NaN and infinite values become the defaults. \rtsafe
  [[nodiscard]] ControllerParameters sanitized() const noexcept;
};

/// Setpoints of the cascade for one step. Position mode uses all three (velocity and torque as feed-forward), velocity
/// mode the last two, torque mode the last.
struct ControllerSetpoint {
  /// The outermost closed loop.
  enum class Loop : unsigned char { kTorque, kVelocity, kPosition };
  Loop loop = Loop::kTorque;    ///< selects the members that are used
  double position_rad = 0.0;    ///< position mode
  double velocity_rad_s = 0.0;  ///< position and velocity mode
  double torque_nm = 0.0;       ///< every mode
};

/// Cascaded servo controller with anti-windup, one step per control cycle. Inputs that are not finite count as 0.
class ServoController {
 public:
  /// Starts at rest at position 0. `step_s`: time between two calls of step(), above 0.
  ServoController(const ControllerParameters& parameters, double step_s) noexcept;

  /// Sets new gains; the state does not change, so this is allowed in motion. \rtsafe
  void configure(const ControllerParameters& parameters) noexcept;
  /// Sets the available torque, lowest <= highest, as a further limit of the torque setpoint. \rtsafe
  void set_available_torque(double lowest_nm, double highest_nm) noexcept {
    lowest_nm_ = lowest_nm;
    highest_nm_ = highest_nm;
  }
  /// Resets all loops to rest at this position; takes over the present torque without a jump. \rtsafe
  void reset(double position_rad, double torque_nm) noexcept;
  /// Updates the speed measurement; must be called in every step, even while no loop is closed. \rtsafe
  void measure(double position_rad) noexcept;
  /// Returns the torque setpoint for this step, within the torque limit. \rtsafe
  [[nodiscard]] double step(const ControllerSetpoint& setpoint) noexcept;

  /// Returns the filtered velocity from measure(). \rtsafe
  [[nodiscard]] double measured_velocity_rad_s() const noexcept { return measured_velocity_rad_s_; }
  /// Returns the setpoint of the velocity loop in the last step in which it was closed. \rtsafe
  [[nodiscard]] double velocity_setpoint_rad_s() const noexcept { return velocity_setpoint_rad_s_; }
  /// Whether the torque or velocity setpoint was limited in the last step.
  [[nodiscard]] bool limited() const noexcept { return limited_; }

 private:
  [[nodiscard]] double limit(double value, double low, double high) noexcept;
  void take_over(double velocity_rad_s, bool could_follow) noexcept;
  [[nodiscard]] double limit_torque(double torque_nm) noexcept;
  [[nodiscard]] double velocity_loop(double velocity_setpoint_rad_s, double torque_nm) noexcept;

  ControllerParameters parameters_;
  double step_s_;
  double steps_per_s_;
  double filter_gain_ = 1.0;
  double integral_gain_ = 0.0;
  double measured_position_rad_ = 0.0;
  double measured_velocity_rad_s_ = 0.0;
  double filtered_feed_forward_rad_s_ = 0.0;
  double velocity_setpoint_rad_s_ = 0.0;
  double taken_over_rad_s_ = 0.0;  ///< remaining offset to the velocity setpoint before the last change of the loop
  double integral_nm_ = 0.0;
  double torque_nm_ = 0.0;
  double lowest_nm_ = -std::numeric_limits<double>::infinity();
  double highest_nm_ = std::numeric_limits<double>::infinity();
  ControllerSetpoint::Loop loop_ = ControllerSetpoint::Loop::kTorque;
  bool limited_ = false;
};

}  // namespace driveline::slaves
