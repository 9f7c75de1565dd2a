#include "driveline/trajectory/limited_axis.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {

void LimitedAxis::rest_at(double position) noexcept {
  last_ = {position, 0.0, 0.0};
  step_velocity_ = 0.0;
  pursuit_.reset();
  stop_.reset();
  at_rest_ = true;
}

/// Limits the velocity of the next step to the nearest value within both limits.
double LimitedAxis::limited_step(double step_velocity) const noexcept {
  const double slowed = std::clamp(step_velocity, step_velocity_ - most_change_, step_velocity_ + most_change_);
  return std::clamp(slowed, -limits_.motion.max_velocity, limits_.motion.max_velocity);
}

/// Whether a step to `position` keeps both limits, up to the rounding of positions.
bool LimitedAxis::is_allowed(double position) const noexcept {
  constexpr double kRounding = 1e-9;
  constexpr double kUlps = 4.0 * std::numeric_limits<double>::epsilon();
  const double step_velocity = step_velocity_to(position);
  const double tolerance = kRounding * most_change_ + kUlps * std::abs(position) * rate_hz_;
  return std::abs(step_velocity - step_velocity_) <= most_change_ + tolerance &&
         std::abs(step_velocity) <= limits_.motion.max_velocity + tolerance;
}

AxisSetpoint LimitedAxis::take(const AxisSetpoint& next) noexcept {
  const auto& [velocity, acceleration] = limits_.motion;
  step_velocity_ = std::clamp(step_velocity_to(next.position), -velocity, velocity);
  last_ = {next.position, std::clamp(next.velocity, -velocity, velocity),
           std::clamp(next.acceleration, -acceleration, acceleration)};
  return last_;
}

/// Moves as close to `position` as one step allows.
AxisSetpoint LimitedAxis::take_nearest(double position) noexcept {
  const double velocity = limited_step(step_velocity_to(position));
  const bool at_limit = std::abs(velocity) >= limits_.motion.max_velocity;
  const double acceleration = at_limit ? 0.0 : (velocity - step_velocity_) * rate_hz_;
  return take({last_.position + velocity * period_s_, velocity, acceleration});
}

AxisSetpoint LimitedAxis::follow(const AxisSetpoint& target) noexcept {
  stop_.reset();
  at_rest_ = false;
  if (!pursuit_) {
    if (is_allowed(target.position)) return take(target);
    pursuit_.emplace(last_.position, step_velocity_, limits_.motion);
  }
  const double top = limits_.motion.max_velocity;
  const auto next =
      pursuit_->step({target.position, std::clamp(target.velocity, -top, top), target.acceleration}, period_s_);
  if (!is_allowed(next.position)) {
    const auto taken = take_nearest(next.position);
    pursuit_.emplace(last_.position, step_velocity_, limits_.motion);
    return taken;
  }
  if (pursuit_->joined()) pursuit_.reset();
  return take(next);
}

AxisSetpoint LimitedAxis::stop() noexcept {
  pursuit_.reset();
  if (!stop_) {
    stop_ = StopProfile::plan(last_, {limits_.motion.max_acceleration, limits_.max_jerk});
    stopping_s_ = 0.0;
  }
  stopping_s_ += period_s_;
  const auto next = stop_ ? stop_->evaluate(stopping_s_) : AxisSetpoint{last_.position, 0.0, 0.0};
  if (!is_allowed(next.position)) {
    stop_.reset();
    return take_nearest(next.position);
  }
  at_rest_ = stop_ && stop_->finished(stopping_s_);
  return take(next);
}

}  // namespace driveline::trajectory
