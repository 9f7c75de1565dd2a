#include "driveline/slaves/plant/servo_controller.hpp"

#include <algorithm>
#include <utility>

#include "in_range.hpp"

namespace driveline::slaves {

namespace {

constexpr double kSetpointTakeOverS = 3e-3;  ///< time constant of the change to a new velocity setpoint (ours)

}  // namespace

ControllerParameters ControllerParameters::sanitized() const noexcept {
  constexpr double kMaxParameter = 1e9;  // the dictionary's maximum
  const ControllerParameters standard;
  return {in_range(position_gain_per_s, 0.0, kMaxParameter, standard.position_gain_per_s),
          in_range(velocity_gain_nm_s, 0.0, kMaxParameter, standard.velocity_gain_nm_s),
          in_range(velocity_reset_s, 0.0, kMaxParameter, standard.velocity_reset_s),
          in_range(velocity_filter_s, 0.0, kMaxParameter, standard.velocity_filter_s),
          in_range(max_velocity_rad_s, 0.0, kMaxParameter, standard.max_velocity_rad_s),
          in_range(max_torque_nm, 0.0, kMaxParameter, standard.max_torque_nm)};
}

ServoController::ServoController(const ControllerParameters& parameters, double step_s) noexcept
    : step_s_(step_s), steps_per_s_(1.0 / step_s) {
  configure(parameters);
}

void ServoController::configure(const ControllerParameters& parameters) noexcept {
  parameters_.position_gain_per_s = at_least(parameters.position_gain_per_s, 0.0);
  parameters_.velocity_gain_nm_s = at_least(parameters.velocity_gain_nm_s, 0.0);
  parameters_.velocity_reset_s = finite(parameters.velocity_reset_s);
  parameters_.velocity_filter_s = at_least(parameters.velocity_filter_s, 0.0);
  parameters_.max_velocity_rad_s = at_least(parameters.max_velocity_rad_s, 0.0);
  parameters_.max_torque_nm = at_least(parameters.max_torque_nm, 0.0);
  filter_gain_ = step_s_ / (step_s_ + parameters_.velocity_filter_s);
  integral_gain_ = parameters_.velocity_reset_s > 0.0
                       ? parameters_.velocity_gain_nm_s * step_s_ / parameters_.velocity_reset_s
                       : 0.0;
}

void ServoController::reset(double position_rad, double torque_nm) noexcept {
  measured_position_rad_ = finite(position_rad);
  measured_velocity_rad_s_ = 0.0;
  filtered_feed_forward_rad_s_ = 0.0;
  velocity_setpoint_rad_s_ = 0.0;
  taken_over_rad_s_ = 0.0;
  integral_nm_ = 0.0;
  torque_nm_ = finite(torque_nm);
  loop_ = ControllerSetpoint::Loop::kTorque;
  limited_ = false;
}

void ServoController::measure(double position_rad) noexcept {
  const double position = finite(position_rad);
  const double velocity = (position - measured_position_rad_) * steps_per_s_;
  measured_position_rad_ = position;
  measured_velocity_rad_s_ += filter_gain_ * (velocity - measured_velocity_rad_s_);
}

double ServoController::limit(double value, double low, double high) noexcept {
  const double limited = std::clamp(value, low, high);
  limited_ = limited_ || limited != value;
  return limited;
}

double ServoController::limit_torque(double torque_nm) noexcept {
  const double most = parameters_.max_torque_nm;
  return limit(torque_nm, std::clamp(lowest_nm_, -most, most), std::clamp(highest_nm_, -most, most));
}

double ServoController::velocity_loop(double velocity_setpoint_rad_s, double torque_nm) noexcept {
  velocity_setpoint_rad_s_ =
      limit(velocity_setpoint_rad_s, -parameters_.max_velocity_rad_s, parameters_.max_velocity_rad_s);
  const double error = velocity_setpoint_rad_s_ - measured_velocity_rad_s_;
  const double proportional = parameters_.velocity_gain_nm_s * error + torque_nm;
  const double wanted = proportional + integral_nm_;
  const double torque = limit_torque(wanted);
  // Anti-windup: do not integrate further into a limit.
  if (torque == wanted || (wanted > torque) != (error > 0.0)) integral_nm_ += integral_gain_ * error;
  integral_nm_ = std::clamp(integral_nm_, -parameters_.max_torque_nm, parameters_.max_torque_nm);
  return torque;
}

/// The velocity loop continues with the present setpoint and approaches the new one, since a step would make the torque
/// jump. Without a present setpoint, or if the axis could not follow it, it continues with the measured speed.
void ServoController::take_over(double velocity_rad_s, bool could_follow) noexcept {
  const bool by_torque = loop_ == ControllerSetpoint::Loop::kTorque;
  const double in_force = by_torque || !could_follow ? measured_velocity_rad_s_ : velocity_setpoint_rad_s_;
  filtered_feed_forward_rad_s_ = velocity_rad_s;
  taken_over_rad_s_ = in_force - velocity_rad_s;
}

double ServoController::step(const ControllerSetpoint& setpoint) noexcept {
  using Loop = ControllerSetpoint::Loop;
  const double velocity = finite(setpoint.velocity_rad_s);
  const double feed_forward_nm = finite(setpoint.torque_nm);
  const bool could_follow = !std::exchange(limited_, false);
  if (setpoint.loop == Loop::kTorque) {
    loop_ = Loop::kTorque;
    torque_nm_ = limit_torque(feed_forward_nm);
    return torque_nm_;
  }
  if (loop_ != setpoint.loop) {
    // Without torque before, as at switch-on, only the filter of the feed-forward smooths its start, because the first
    // setpoints may jump, e.g. in new units.
    const bool from_nothing = loop_ == Loop::kTorque && !(std::abs(torque_nm_) > 0.0);
    take_over(velocity, could_follow);
    if (from_nothing && setpoint.loop == Loop::kPosition) {
      filtered_feed_forward_rad_s_ = velocity + std::exchange(taken_over_rad_s_, 0.0);
    }
  }
  const double taken_over = taken_over_rad_s_;
  double velocity_setpoint = velocity + taken_over;
  taken_over_rad_s_ -= taken_over_rad_s_ * step_s_ / kSetpointTakeOverS;
  if (setpoint.loop == Loop::kPosition) {
    // The speed measurement lags by its filter; without the same delay the feed-forward would appear as an error.
    filtered_feed_forward_rad_s_ += filter_gain_ * (velocity - filtered_feed_forward_rad_s_);
    velocity_setpoint = filtered_feed_forward_rad_s_ + taken_over +
                        parameters_.position_gain_per_s * (finite(setpoint.position_rad) - measured_position_rad_);
  }
  if (loop_ == Loop::kTorque) {
    // The integral part takes over the torque, so that it continues unchanged without a speed error. The first
    // feed-forward may result from a kink, so only the part of it counts that the torque may already contain.
    const double part = std::clamp(feed_forward_nm, std::min(torque_nm_, 0.0), std::max(torque_nm_, 0.0));
    integral_nm_ = std::clamp(torque_nm_ - part, -parameters_.max_torque_nm, parameters_.max_torque_nm);
  }
  loop_ = setpoint.loop;
  torque_nm_ = velocity_loop(velocity_setpoint, feed_forward_nm);
  return torque_nm_;
}

}  // namespace driveline::slaves
