// What a single axis is asked, and what is refused.
#include <algorithm>
#include <cmath>

#include "driveline/ecat_master/single_axis/single_axis.hpp"

namespace driveline::ecat_master {
namespace {

/// A limit may be met exactly, and be written with fewer digits.
constexpr double kRounding = 1.0 + 1e-9;
constexpr double kHighestOverride = 2.0;

bool is_motion(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kHalt:
    case AxisCommand::kStop:
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kFollow:
      return true;
    default:
      return false;
  }
}

bool is_magnitude(double value) noexcept {
  return std::isfinite(value) && value >= 0.0;
}

}  // namespace

void SingleAxis::finish(std::uint64_t& id, RequestPhase phase, AxisError error) noexcept {
  if (id != 0) table_->set(id, {phase, error});
  id = 0;
}

void SingleAxis::finish_move(RequestPhase phase, AxisError error) noexcept {
  if (active_) finish(active_->id, phase, error);
  active_.reset();
  finish(superimposed_request_, phase, error);
}

void SingleAxis::drop_waiting(AxisError error) noexcept {
  for (std::size_t i = 0; i < waiting_count_; ++i) finish(waiting_[i].id, RequestPhase::kAborted, error);
  waiting_count_ = 0;
}

AxisError SingleAxis::refusal_by_state(AxisCommand command) const noexcept {
  const bool motion = is_motion(command);
  if (state_ == PlcopenState::kErrorStop) {
    const bool allowed = command == AxisCommand::kReset || command == AxisCommand::kSetOverride;
    return allowed ? AxisError::kNone : AxisError::kErrorStop;
  }
  if (motion && power_ != Power::kOn) return AxisError::kNotEnabled;
  if (motion && state_ == PlcopenState::kStopping && command != AxisCommand::kStop) return AxisError::kStopping;
  if (command == AxisCommand::kFollow && !fed_) return AxisError::kNothingToDo;
  if (command == AxisCommand::kReleaseStop && state_ != PlcopenState::kStopping) return AxisError::kNothingToDo;
  return AxisError::kNone;
}

AxisError SingleAxis::refusal_by_numbers(const AxisRequest& request) const noexcept {
  const auto& limits = axis_->config().limits;
  if (!std::isfinite(request.target)) return AxisError::kNotFinite;
  for (const double magnitude : {request.velocity, request.acceleration, request.deceleration, request.jerk}) {
    if (!is_magnitude(magnitude)) return AxisError::kNotFinite;
  }
  const double speed =
      std::max(request.velocity, request.command == AxisCommand::kMoveVelocity ? std::abs(request.target) : 0.0);
  const bool over = speed > limits.max_velocity * kRounding ||
                    request.acceleration > limits.max_acceleration * kRounding ||
                    request.deceleration > limits.max_acceleration * kRounding;
  if (is_motion(request.command) && over) return AxisError::kOverLimit;
  const bool factor = request.command == AxisCommand::kSetOverride;
  if (factor && (request.target < 0.0 || request.target > kHighestOverride)) return AxisError::kOverLimit;
  return AxisError::kNone;
}

AxisError SingleAxis::refusal(const AxisRequest& request) const noexcept {
  if (request.command == AxisCommand::kPower && !request.on) return AxisError::kNone;
  const auto by_state = refusal_by_state(request.command);
  return by_state != AxisError::kNone ? by_state : refusal_by_numbers(request);
}

void SingleAxis::take(std::uint64_t id, const AxisRequest& request) noexcept {
  if (const auto error = refusal(request); error != AxisError::kNone) return finish(id, RequestPhase::kError, error);
  switch (request.command) {
    case AxisCommand::kPower:
      return take_power(id, request.on);
    case AxisCommand::kReset:
      return take_reset(id);
    case AxisCommand::kReleaseStop:
      // While it is on its way to rest, it halts.
      state_ = active_ ? PlcopenState::kDiscreteMotion : PlcopenState::kStandstill;
      return finish(id, RequestPhase::kDone);
    case AxisCommand::kSetOverride:
      return take_override(id, request.target);
    case AxisCommand::kSetPosition:
      offset_ = request.target - setpoint_.position;
      return finish(id, RequestPhase::kDone);
    case AxisCommand::kMoveSuperimposed:
      return take_superimposed(id, request);
    case AxisCommand::kHome:
    case AxisCommand::kTorque:
    case AxisCommand::kSetMode:
      return finish(id, RequestPhase::kError, AxisError::kMode);
    default:
      return take_motion(id, request);
  }
}

void SingleAxis::take_power(std::uint64_t id, bool on) noexcept {
  finish(power_request_, RequestPhase::kAborted);
  const bool there = on ? power_ == Power::kOn : power_ == Power::kOff;
  if (there) return finish(id, RequestPhase::kDone);
  power_request_ = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  if (on && power_ == Power::kResting) {
    // On its way to rest it keeps its power, and halts.
    enter(Power::kOn);
    begin_move({});
    return finish(power_request_, RequestPhase::kDone);
  }
  if (on) return enter(Power::kEnabling);
  finish_move(RequestPhase::kAborted);
  drop_waiting(AxisError::kNone);
  if (power_ == Power::kEnabling) return enter(Power::kDisabling);
  if (power_ != Power::kOn) return;
  if (plan_rest()) return enter(Power::kResting);
  fail(AxisError::kNotFinite);
}

void SingleAxis::take_reset(std::uint64_t id) noexcept {
  if (state_ != PlcopenState::kErrorStop) return finish(id, RequestPhase::kDone);
  finish(reset_request_, RequestPhase::kAborted);
  reset_request_ = id;
  reset_since_ = cycle_;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
}

void SingleAxis::take_override(std::uint64_t id, double factor) noexcept {
  override_ = factor;
  if (active_) replan();
  finish(id, RequestPhase::kDone);
}

void SingleAxis::take_motion(std::uint64_t id, const AxisRequest& request) noexcept {
  const Move move{id, request, 0.0};
  // A velocity never ends, so nothing waits behind it; a feed may.
  const bool waits = request.buffer != BufferMode::kAborting && active_.has_value();
  if (!waits) {
    finish_move(RequestPhase::kAborted);
    drop_waiting(AxisError::kNone);
    return begin_move(move);
  }
  if (waiting_count_ == kWaiting) {
    auto refused = id;
    return finish(refused, RequestPhase::kError, AxisError::kBufferFull);
  }
  waiting_[waiting_count_++] = move;
  // The motion under way may pass its end at a velocity now.
  if (waiting_count_ == 1) replan();
}

/// On top of a motion to a position it becomes a part of it, so the sum of both obeys the limits of the axis.
void SingleAxis::take_superimposed(std::uint64_t id, const AxisRequest& request) noexcept {
  if (!active_) {
    auto alone = request;
    alone.command = AxisCommand::kMoveRelative;
    return take_motion(id, alone);
  }
  const auto under_way = active_->request.command;
  const bool to_position = under_way == AxisCommand::kMoveAbsolute || under_way == AxisCommand::kMoveRelative ||
                           under_way == AxisCommand::kMoveAdditive;
  if (!to_position) return finish(id, RequestPhase::kError, AxisError::kNothingToDo);
  finish(superimposed_request_, RequestPhase::kAborted);
  superimposed_request_ = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  const double sum = velocity_of(active_->request) + velocity_of(request);
  active_->request.velocity = std::min(sum, axis_->config().limits.max_velocity);
  active_->target += request.target;
  last_target_ = active_->target;
  replan();
}

}  // namespace driveline::ecat_master
