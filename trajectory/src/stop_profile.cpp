#include "driveline/trajectory/stop_profile.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Durations of the three phases and the acceleration in the middle one.
struct Plan {
  double rise_s;
  double hold_s;
  double fall_s;
  double acceleration;
};

/// Time-optimal motion from (velocity, acceleration) to (0, 0) with limited acceleration and jerk. The frame is chosen
/// such that the velocity that remains when the acceleration is reduced at once, v + a|a| / (2 jerk), is not negative.
/// Then the axis must decelerate: down to -peak, hold, back to zero.
Plan plan_stop(double velocity, double acceleration, const StopLimits& limits) noexcept {
  const double deceleration = limits.max_deceleration;
  const double jerk = limits.max_jerk;
  // Velocity to be removed after the acceleration has fallen to zero on its way to -peak.
  const double surplus = velocity + acceleration * acceleration / (2.0 * jerk);
  const bool reaches_limit = surplus >= deceleration * deceleration / jerk;
  const double peak = reaches_limit ? deceleration : std::sqrt(jerk * surplus);
  const double rise_s = std::abs(acceleration + peak) / jerk;
  const double fall_s = peak / jerk;
  if (!reaches_limit) {
    return {rise_s, 0.0, fall_s, -peak};
  }
  const double lost_while_holding = velocity + rise_s * (acceleration - peak) / 2.0 - fall_s * peak / 2.0;
  return {rise_s, std::max(0.0, lost_while_holding / peak), fall_s, -peak};
}

}  // namespace

AxisSetpoint StopProfile::Phase::at(double t) const noexcept {
  return {start.position + t * (start.velocity + t * (start.acceleration / 2.0 + t * jerk / 6.0)),
          start.velocity + t * (start.acceleration + t * jerk / 2.0), start.acceleration + t * jerk};
}

std::optional<StopProfile> StopProfile::plan(const AxisSetpoint& state, const StopLimits& limits) noexcept {
  if (!std::isfinite(state.position) || !std::isfinite(state.velocity) || !std::isfinite(state.acceleration) ||
      !(limits.max_deceleration > 0.0) || !std::isfinite(limits.max_deceleration) || !(limits.max_jerk > 0.0)) {
    return std::nullopt;
  }
  const double a = state.acceleration;
  const double direction = state.velocity + a * std::abs(a) / (2.0 * limits.max_jerk) < 0.0 ? -1.0 : 1.0;
  const Plan plan = plan_stop(direction * state.velocity, direction * a, limits);
  const double middle = direction * plan.acceleration;

  StopProfile profile;
  auto& [rise, hold, fall] = profile.phases_;
  rise = {plan.rise_s, plan.rise_s > 0.0 ? (middle - a) / plan.rise_s : 0.0, state};
  hold = {plan.hold_s, 0.0, rise.at(rise.duration_s)};
  hold.start.acceleration = middle;
  fall = {plan.fall_s, plan.fall_s > 0.0 ? -middle / plan.fall_s : 0.0, hold.at(hold.duration_s)};
  profile.duration_s_ = rise.duration_s + hold.duration_s + fall.duration_s;
  profile.end_position_ = fall.at(fall.duration_s).position;
  if (!std::isfinite(profile.duration_s_) || !std::isfinite(profile.end_position_)) {
    return std::nullopt;
  }
  return profile;
}

AxisSetpoint StopProfile::evaluate(double elapsed_s) const noexcept {
  if (finished(elapsed_s)) {
    return {end_position_, 0.0, 0.0};
  }
  double t = elapsed_s > 0.0 ? elapsed_s : 0.0;
  for (const Phase& phase : phases_) {
    if (t < phase.duration_s) {
      return phase.at(t);
    }
    t -= phase.duration_s;
  }
  return {end_position_, 0.0, 0.0};
}

}  // namespace driveline::trajectory
