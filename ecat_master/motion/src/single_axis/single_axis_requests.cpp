// Requests to a single axis, and reasons to refuse them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

/// A value may equal a limit, and may be written with fewer digits.
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
    case AxisCommand::kHaltSuperimposed:
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kFollow:
    case AxisCommand::kTorque:
      return true;
    default:
      return false;
  }
}

/// Whether the command is refused while the axis is being homed.
bool needs_drive(AxisCommand command) noexcept {
  return is_motion(command) || command == AxisCommand::kHome || command == AxisCommand::kSetMode ||
         command == AxisCommand::kSetPosition || command == AxisCommand::kHomeByProbe;
}

bool is_profile(AxisCommand command) noexcept {
  return positions_by_drive(command) || runs_by_drive(command);
}

/// Whether the command must start at standstill.
bool begins_at_rest(AxisCommand command) noexcept {
  return command == AxisCommand::kHome || command == AxisCommand::kHomeByProbe || is_profile(command);
}

/// Whether the command may replace a movement of the drive's profile generator, which is then halted.
bool may_replace_profile(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kHalt:
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveVelocity:
      return true;
    default:
      return false;
  }
}

/// Whether the command needs setpoints, which an axis does not have whose drive plans its motions.
bool needs_setpoints(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kHaltSuperimposed:
    case AxisCommand::kFollow:
    case AxisCommand::kTorque:
    case AxisCommand::kSetOverride:
    case AxisCommand::kSetMode:
    case AxisCommand::kHomeByProbe:
      return true;
    default:
      return false;
  }
}

/// The same movement by the profile generator of the drive, where there is one.
AxisRequest as_movement_of_drive(AxisRequest request) noexcept {
  if (request.command == AxisCommand::kMoveAbsolute) request.command = AxisCommand::kDriveMoveAbsolute;
  if (request.command == AxisCommand::kMoveRelative) request.command = AxisCommand::kDriveMoveRelative;
  if (request.command == AxisCommand::kMoveVelocity) request.command = AxisCommand::kDriveMoveVelocity;
  return request;
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
  drop_superimposed();
  if (active_) finish(active_->id, phase, error);
  active_.reset();
  run_velocity_.reset();
  end_search();
  finish(on_top_.request, phase, error);
}

void SingleAxis::drop_waiting(AxisError error) noexcept {
  for (auto& move : waiting_) finish(move.id, RequestPhase::kAborted, error);
  waiting_.clear();
  due_ = Due::kNone;
}

AxisError SingleAxis::refusal_by_state(const AxisRequest& request) const noexcept {
  const auto command = request.command;
  const bool motion = is_motion(command);
  if (state_ == PlcopenState::kErrorStop) {
    const bool allowed = command == AxisCommand::kReset || command == AxisCommand::kSetOverride;
    return allowed ? AxisError::kNone : AxisError::kErrorStop;
  }
  const bool at_rest = begins_at_rest(command);
  if ((motion || at_rest) && power_.phase != Power::kOn) return AxisError::kNotEnabled;
  if (const auto error = refusal_by_drive(request); error != AxisError::kNone) return error;
  if (at_rest && drive_.phase == ByDrive::kNone && state_ != PlcopenState::kStandstill) return AxisError::kNotAtRest;
  if (motion && state_ == PlcopenState::kStopping && command != AxisCommand::kStop) return AxisError::kStopping;
  if (command == AxisCommand::kFollow && !feed_.present) return AxisError::kNothingToDo;
  if (command == AxisCommand::kReleaseStop && state_ != PlcopenState::kStopping) return AxisError::kNothingToDo;
  return AxisError::kNone;
}

/// Refusal while the drive generates the motion, or while the master homes the axis.
AxisError SingleAxis::refusal_by_drive(const AxisRequest& request) const noexcept {
  const auto command = request.command;
  if (command == AxisCommand::kStop) return AxisError::kNone;
  if (homing_.search != Search::kNone) {
    const bool meanwhile = needs_drive(command) || is_profile(command) || command == AxisCommand::kTouchProbe;
    return meanwhile ? AxisError::kNotAtRest : AxisError::kNone;
  }
  if (drive_.phase == ByDrive::kNone) return AxisError::kNone;
  if (is_profile(command) && waits_for_drive(request)) return AxisError::kNone;
  if (is_profile(command)) {
    // Another target of the same mode is sent at once; the other mode starts at standstill.
    const bool same = drive_mode(command) == drive_mode(drive_.command);
    return !homes() && same && drive_.phase == ByDrive::kRunning ? AxisError::kNone : AxisError::kNotAtRest;
  }
  if (!needs_drive(command) || (!homes() && may_replace_profile(command))) return AxisError::kNone;
  return AxisError::kNotAtRest;
}

AxisError SingleAxis::refusal_by_numbers(const AxisRequest& request) const noexcept {
  const auto& limits = axis_->config().limits;
  if (!std::isfinite(request.target_si)) return AxisError::kNotFinite;
  if (names_position(request.command) && !representable(axis_->config(), request.target_si)) return AxisError::kTooFar;
  for (const double magnitude :
       {request.velocity_si, request.acceleration_si, request.deceleration_si, request.jerk_si}) {
    if (!is_magnitude(magnitude)) return AxisError::kNotFinite;
  }
  const bool runs = request.command == AxisCommand::kMoveVelocity || runs_by_drive(request.command);
  const double speed = std::max(request.velocity_si, runs ? std::abs(request.target_si) : 0.0);
  const bool over = speed > limits.max_velocity * kRounding ||
                    request.acceleration_si > limits.max_acceleration * kRounding ||
                    request.deceleration_si > limits.max_acceleration * kRounding ||
                    request.jerk_si > axis_->config().max_jerk.value_or(request.jerk_si) * kRounding;
  const bool directed = request.direction != MoveDirection::kNone;
  if (directed && (request.command != AxisCommand::kMoveAbsolute || !axis_->config().modulo))
    return AxisError::kDirection;
  if (request.command == AxisCommand::kTorque) return refusal_of_torque(request);
  if ((is_motion(request.command) || begins_at_rest(request.command)) && over) return AxisError::kOverLimit;
  if (is_profile(request.command)) return refusal_of_profile(request);
  if (request.command == AxisCommand::kTouchProbe || request.command == AxisCommand::kHomeByProbe)
    return refusal_of_probe(request);
  const bool factor = request.command == AxisCommand::kSetOverride;
  if (factor && (request.target_si < 0.0 || request.target_si > kHighestOverride)) return AxisError::kOverLimit;
  return AxisError::kNone;
}

AxisError SingleAxis::refusal_of_torque(const AxisRequest& request) const noexcept {
  const auto& config = axis_->config();
  const double range = config.rated_torque * std::numeric_limits<std::int16_t>::max() / 1000.0;
  const double most = std::min(config.max_torque.value_or(range) * kRounding, range);
  const bool over = request.velocity_si > config.limits.max_velocity * kRounding ||
                    request.deceleration_si > config.limits.max_acceleration * kRounding ||
                    request.jerk_si > config.max_jerk.value_or(request.jerk_si) * kRounding;
  if (over || std::abs(request.target_si) > most) return AxisError::kOverLimit;
  if (!axis_->supports(cia402::Mode::kCyclicTorque)) return AxisError::kNoSuchMode;
  const bool possible = axis_->can_change(cia402::Mode::kCyclicTorque) && mode_may_change();
  return possible ? AxisError::kNone : AxisError::kMode;
}

AxisError SingleAxis::refusal(const AxisRequest& request) const noexcept {
  if (request.command == AxisCommand::kPower && !request.on) return AxisError::kNone;
  if (cia402::by_drive(axis_->config().mode) && needs_setpoints(request.command)) return AxisError::kMode;
  const auto by_state = refusal_by_state(request);
  return by_state != AxisError::kNone ? by_state : refusal_by_numbers(request);
}

void SingleAxis::take(std::uint64_t id, const AxisRequest& given) noexcept {
  const auto request = cia402::by_drive(axis_->config().mode) ? as_movement_of_drive(given) : given;
  if (const auto error = refusal(request); error != AxisError::kNone) return finish(id, RequestPhase::kError, error);
  switch (request.command) {
    case AxisCommand::kPower:
      return take_power(id, request.on);
    case AxisCommand::kReset:
      return take_reset(id);
    case AxisCommand::kReleaseStop:
      // If the axis is still decelerating, the stop becomes a halt.
      state_ = active_ ? PlcopenState::kDiscreteMotion : PlcopenState::kStandstill;
      return finish(id, RequestPhase::kDone);
    case AxisCommand::kSetOverride:
      return take_override(id, request.target_si);
    case AxisCommand::kSetPosition:
      offset_ = request.target_si - setpoint_.position;
      // A waiting motion may now lead to another position.
      if (generator_.goes_on()) replan();
      return finish(id, RequestPhase::kDone);
    case AxisCommand::kMoveSuperimposed:
      return take_superimposed(id, request);
    case AxisCommand::kHaltSuperimposed:
      return take_halt_superimposed(id);
    case AxisCommand::kSetMode:
      return take_mode(id, request.mode);
    case AxisCommand::kHome:
      return take_home(id);
    case AxisCommand::kTouchProbe:
      return take_probe(id, request);
    case AxisCommand::kAbortTrigger:
      return take_abort_trigger(id);
    case AxisCommand::kHomeByProbe:
      return take_search(id, request);
    case AxisCommand::kDriveMoveAbsolute:
    case AxisCommand::kDriveMoveRelative:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return take_profile(id, request);
    default:
      return take_motion(id, request);
  }
}

void SingleAxis::take_power(std::uint64_t id, bool on) noexcept {
  finish(power_.request, RequestPhase::kAborted);
  const bool there = on ? power_.phase == Power::kOn : power_.phase == Power::kOff;
  if (there) return finish(id, RequestPhase::kDone);
  power_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  if (on && power_.phase == Power::kResting) {
    // The axis is coming to rest: keep the power, and halt.
    enter(Power::kOn);
    begin_move({});
    return finish(power_.request, RequestPhase::kDone);
  }
  if (on) return enter(Power::kEnabling);
  finish_move(RequestPhase::kAborted);
  drop_waiting(AxisError::kNone);
  if (power_.phase == Power::kEnabling) return enter(Power::kDisabling);
  if (power_.phase != Power::kOn) return;
  interrupt_drive();
  leave_torque();
  if (plan_rest()) return enter(Power::kResting);
  fail(AxisError::kNotFinite);
}

void SingleAxis::take_reset(std::uint64_t id) noexcept {
  if (state_ != PlcopenState::kErrorStop) return finish(id, RequestPhase::kDone);
  finish(reset_.request, RequestPhase::kAborted);
  reset_.request = id;
  reset_.since = cycle_;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
}

void SingleAxis::take_override(std::uint64_t id, double factor) noexcept {
  const double before = std::exchange(override_, factor);
  if (active_ && !can_continue()) {
    override_ = before;
    return finish(id, RequestPhase::kError, AxisError::kTooLong);
  }
  if (active_) replan();
  finish(id, RequestPhase::kDone);
}

void SingleAxis::take_mode(std::uint64_t id, std::int8_t mode) noexcept {
  const auto wanted = static_cast<cia402::Mode>(mode);
  const bool known = (cia402::cyclic(wanted) && wanted <= cia402::Mode::kCyclicTorque) ||
                     wanted == cia402::Mode::kInterpolatedPosition;
  if (known && !axis_->supports(wanted)) return finish(id, RequestPhase::kError, AxisError::kNoSuchMode);
  if (!known || torque_.phase != Torque::kNone) return finish(id, RequestPhase::kError, AxisError::kMode);
  finish(mode_change_.request, RequestPhase::kAborted);
  if (!change_mode(wanted)) return finish(id, RequestPhase::kError, AxisError::kMode);
  mode_change_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
}

/// Starts a change to another mode of the setpoints.
bool SingleAxis::change_mode(cia402::Mode mode) noexcept {
  const auto before = axis_->mode();
  if (!axis_->set_mode(mode)) return false;
  mode_change_.before = before;
  mode_change_.since = cycle_;
  mode_change_.under_way = true;
  if (active_) replan();
  if (power_.phase == Power::kResting && !plan_rest()) fail(AxisError::kNotFinite);
  return true;
}

void SingleAxis::take_motion(std::uint64_t id, const AxisRequest& request) noexcept {
  const Move move{id, request, 0.0};
  // A motion waits only if another one is under way.
  const bool waits = request.buffer != BufferMode::kAborting && active_.has_value();
  if (!waits) {
    const auto error = refusal_of_motion(move);
    if (error != AxisError::kNone) return finish(id, RequestPhase::kError, error);
    finish_move(RequestPhase::kAborted);
    drop_waiting(AxisError::kNone);
    interrupt_drive();
    return begin_move(move);
  }
  if (!keep_waiting(move)) return;
  // The motion under way may now pass its end at a velocity.
  if (waiting_.size() == 1) replan();
}

/// Superimposed on a motion to a position, it becomes a part of that motion, so that the sum obeys the limits of the
/// axis.
void SingleAxis::take_superimposed(std::uint64_t id, const AxisRequest& request) noexcept {
  if (!active_) {
    auto alone = request;
    alone.command = AxisCommand::kMoveRelative;
    return take_motion(id, alone);
  }
  const auto under_way = active_->request.command;
  const bool to_position = under_way == AxisCommand::kMoveAbsolute || under_way == AxisCommand::kMoveRelative ||
                           under_way == AxisCommand::kMoveAdditive;
  if (!to_position && superimpose(id, request)) return;
  if (!to_position) return finish(id, RequestPhase::kError, AxisError::kNothingToDo);
  if (!in_range(active_->target + request.target_si)) return finish(id, RequestPhase::kError, AxisError::kOutsideRange);
  auto both = active_->request;
  both.velocity_si =
      std::min(velocity_of(active_->request) + velocity_of(request), axis_->config().limits.max_velocity);
  if (override_ > 0.0 && !way_to(active_->target + request.target_si, both))
    return finish(id, RequestPhase::kError, AxisError::kTooLong);
  finish(on_top_.request, RequestPhase::kAborted);
  on_top_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  active_->request = both;
  active_->target += request.target_si;
  last_target_ = active_->target;
  replan();
}

}  // namespace driveline::motion
