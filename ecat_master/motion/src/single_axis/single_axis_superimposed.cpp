// Superimposed motions on a motion without an end: one at a velocity, or followed setpoints.
#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

/// Defaults if the request gives no value: share of max_acceleration; share of max_velocity if the velocity below is
/// unknown.
constexpr double kShareOnTop = 0.5;
constexpr double kShareOfVelocity = 0.1;

}  // namespace

/// Velocity that the motion below leaves; that of followed setpoints is unknown.
double SingleAxis::velocity_on_top(const AxisRequest& request) const noexcept {
  const double most = axis_->config().limits.max_velocity;
  if (active_->request.command != AxisCommand::kMoveVelocity)
    return request.velocity_si > 0.0 ? request.velocity_si : kShareOfVelocity * most;
  const double left = most - std::min(std::abs(active_->request.target_si * override_), most);
  return request.velocity_si > 0.0 && request.velocity_si <= left * (1.0 + 1e-9) ? request.velocity_si
         : request.velocity_si > 0.0                                             ? 0.0
                                                                                 : left;
}

/// Returns false if there is no motion to superimpose on.
bool SingleAxis::superimpose(std::uint64_t id, const AxisRequest& request) noexcept {
  const auto below = active_->request.command;
  if (below != AxisCommand::kMoveVelocity && below != AxisCommand::kFollow) return false;
  const auto& config = axis_->config();
  const double velocity = velocity_on_top(request);
  if (!(velocity > 1e-6 * config.limits.max_velocity)) {
    finish(id, RequestPhase::kError, AxisError::kOverLimit);
    return true;
  }
  const double most = config.limits.max_acceleration;
  const double acceleration = request.acceleration_si > 0.0 ? request.acceleration_si : kShareOnTop * most;
  const double own_jerk = config.max_jerk.value_or(std::numeric_limits<double>::infinity());
  const auto limits = trajectory::ProfileLimits::symmetric(velocity, std::min(acceleration, most),
                                                           request.jerk_si > 0.0 ? request.jerk_si : own_jerk);
  const double from = on_top_.motion.state().position;
  if (!on_top_.motion.to_position({from + request.target_si, 0.0, 0.0}, limits)) {
    finish(id, RequestPhase::kError, AxisError::kTooLong);
    return true;
  }
  finish(on_top_.request, RequestPhase::kAborted);
  on_top_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  on_top_.active = true;
  on_top_.velocity = velocity;
  // Plan the velocity below again from here: after a gap its plan started elsewhere.
  if (below == AxisCommand::kMoveVelocity) replan();
  return true;
}

void SingleAxis::take_halt_superimposed(std::uint64_t id) noexcept {
  if (!on_top_.active || on_top_.request == 0) return finish(id, RequestPhase::kError, AxisError::kNothingToDo);
  if (!on_top_.motion.to_velocity(0.0, full_limits())) return finish(id, RequestPhase::kError, AxisError::kNotFinite);
  finish(on_top_.request, RequestPhase::kAborted);
  on_top_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
}

/// Moves one step by the sum of both motions, within the limits of the axis.
void SingleAxis::step_on_top(const trajectory::AxisSetpoint& target) noexcept {
  // Check the state after one more step in the worst case.
  const double faster = std::copysign(most_acceleration() * period_s_, step_velocity_);
  const double then = step_velocity_ + faster;
  if (leaves_range({setpoint_.position + then * period_s_, then, 0.0})) {
    finish_move(RequestPhase::kError, AxisError::kOutsideRange);
    drop_waiting(AxisError::kNone);
    begin_move({});
    return step_to(generator_.advance(period_s_));
  }
  lead_to(with_on_top(target));
  if (rejoin_.joined() && !beside_) settle_superimposed();
}

/// Ends a finished superimposed motion: it becomes a part of a velocity motion, and stays an offset to followed
/// setpoints.
void SingleAxis::settle_superimposed() noexcept {
  if (!on_top_.motion.finished()) return;
  finish(on_top_.request, RequestPhase::kDone);
  if (active_->request.command == AxisCommand::kFollow) return;
  auto below = generator_.state();
  below.position += on_top_.motion.state().position;
  on_top_.active = false;
  on_top_.motion.start_from({});
  generator_.start_from(below);
  replan();
}

/// Drops the superimposed motion when the motion below ends; the next motion starts from their sum.
void SingleAxis::drop_superimposed() noexcept {
  if (!on_top_.active) return;
  finish(on_top_.request, RequestPhase::kAborted);
  on_top_.active = false;
  on_top_.motion.start_from({});
  generator_.start_from({setpoint_.position, step_velocity_, setpoint_.acceleration});
}

}  // namespace driveline::motion
