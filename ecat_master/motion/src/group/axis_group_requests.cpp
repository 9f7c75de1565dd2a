// Requests to a group, and reasons to refuse them.
#include <algorithm>
#include <cmath>

#include "axis_group.hpp"
#include "driveline/trajectory/contour_settings.hpp"

namespace driveline::motion {

void AxisGroup::finish(std::uint64_t& id, RequestPhase phase, GroupError error, std::size_t axis) noexcept {
  table_.set(id, {phase, error, axis});
  id = 0;
}

/// Starts a request; it replaces one of the same kind.
void AxisGroup::begin(std::uint64_t& place, std::uint64_t id) noexcept {
  finish(place, RequestPhase::kAborted);
  place = id;
  table_.set(id, {RequestPhase::kActive, GroupError::kNone, 0});
}

GroupError AxisGroup::refusal(const GroupRequest& request) const noexcept {
  if (request.command == GroupCommand::kSetOverride) {
    if (!std::isfinite(request.value)) return GroupError::kNotFinite;
    const bool over = request.value < 0.0 || request.value > trajectory::kMaxOverride;
    return over ? GroupError::kOverLimit : GroupError::kNone;
  }
  return refusal_by_state(request.command);
}

GroupError AxisGroup::refusal_by_state(GroupCommand command) const noexcept {
  if (command == GroupCommand::kReset) return GroupError::kNone;
  if (state_ == GroupState::kErrorStop) return GroupError::kErrorStop;
  const bool of_stop = command == GroupCommand::kStop || command == GroupCommand::kReleaseStop;
  if (state_ == GroupState::kStopping && !of_stop) return GroupError::kStopping;
  if (command == GroupCommand::kEnable) return releasing_ ? GroupError::kAxisMoves : GroupError::kNone;
  if (command == GroupCommand::kDisable) return GroupError::kNone;
  if (!leads()) return GroupError::kNotEnabled;
  const bool follows = followed_.there() && !ending_;
  switch (command) {
    case GroupCommand::kReleaseStop:
      return state_ == GroupState::kStopping ? GroupError::kNone : GroupError::kNothingToDo;
    case GroupCommand::kInterrupt:
      return follows && state_ == GroupState::kMoving && !interrupted_ ? GroupError::kNone : GroupError::kNothingToDo;
    case GroupCommand::kContinue:
      return interrupted_ ? GroupError::kNone : GroupError::kNothingToDo;
    case GroupCommand::kReverse:
    case GroupCommand::kForward:
      return follows ? GroupError::kNone : GroupError::kNothingToDo;
    default:
      return GroupError::kNone;
  }
}

void AxisGroup::take(std::uint64_t id, const GroupRequest& request) noexcept {
  if (const auto error = refusal(request); error != GroupError::kNone) return finish(id, RequestPhase::kError, error);
  switch (request.command) {
    case GroupCommand::kEnable:
      return take_enable(id);
    case GroupCommand::kDisable:
      return take_disable(id);
    case GroupCommand::kReset:
      return take_reset(id);
    case GroupCommand::kStop:
      return take_stop(id);
    case GroupCommand::kReleaseStop:
      release_stop();
      break;
    case GroupCommand::kHalt:
      begin(pending_.halt, id);
      return end_path(id, GroupError::kNone, 0);
    case GroupCommand::kInterrupt:
      interrupted_ = true;
      set_hold();
      return begin(pending_.interrupt, id);
    case GroupCommand::kContinue:
      interrupted_ = false;
      set_hold();
      finish(pending_.interrupt, RequestPhase::kAborted);
      break;
    case GroupCommand::kSetOverride:
      override_ = request.value;
      if (followed_.there()) followed_.path().set_override(override_);
      break;
    case GroupCommand::kReverse:
    case GroupCommand::kForward:
      backwards_ = request.command == GroupCommand::kReverse;
      followed_.path().reverse(backwards_);
      if (state_ == GroupState::kStandby) state_ = GroupState::kMoving;
      break;
  }
  finish(id, RequestPhase::kDone);
}

GroupError AxisGroup::refusal_of(std::size_t place) const noexcept {
  switch (axes_.axis(members_[place]).state()) {
    case PlcopenState::kStandstill:
      return GroupError::kNone;
    case PlcopenState::kDisabled:
      return GroupError::kAxisNotEnabled;
    case PlcopenState::kErrorStop:
      return GroupError::kAxisErrorStop;
    default:
      return GroupError::kAxisMoves;
  }
}

/// Takes over all axes or none.
void AxisGroup::take_enable(std::uint64_t id) noexcept {
  if (state_ != GroupState::kDisabled) return finish(id, RequestPhase::kDone);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (const auto error = refusal_of(i); error != GroupError::kNone)
      return finish(id, RequestPhase::kError, error, members_[i]);
  }
  for (std::size_t i = 0; i < members_.size(); ++i) {
    follow_requests_[i] = axes_.follow_in_cycle(members_[i]);
    if (axes_.axis(members_[i]).follows()) continue;
    let_go(i);
    return finish(id, RequestPhase::kError, GroupError::kAxisRefused, members_[i]);
  }
  state_ = GroupState::kStandby;
  enabling_ = true;
  ending_ = false;
  interrupted_ = false;
  backwards_ = false;
  begin(pending_.enable, id);
}

/// Releases the first `places` axes, which already follow.
void AxisGroup::let_go(std::size_t places) noexcept {
  for (std::size_t i = 0; i < places; ++i) axes_.pass_on_in_cycle(members_[i], 0, {.command = AxisCommand::kHalt});
}

void AxisGroup::take_disable(std::uint64_t id) noexcept {
  if (state_ == GroupState::kDisabled) return finish(id, RequestPhase::kDone);
  begin(pending_.disable, id);
  if (!releasing_) end_path(id, GroupError::kNone, 0);
}

void AxisGroup::take_stop(std::uint64_t id) noexcept {
  begin(pending_.stop, id);
  finish(pending_.halt, RequestPhase::kAborted);
  finish(pending_.disable, RequestPhase::kAborted);
  finish(pending_.interrupt, RequestPhase::kAborted);
  state_ = GroupState::kStopping;
  end_path(id, GroupError::kNone, 0);
}

/// If the axes are still decelerating, the stop becomes a halt.
void AxisGroup::release_stop() noexcept {
  state_ = ending_ ? GroupState::kMoving : GroupState::kStandby;
}

void AxisGroup::take_reset(std::uint64_t id) noexcept {
  if (state_ != GroupState::kErrorStop) return finish(id, RequestPhase::kDone);
  std::fill(reset_requests_.begin(), reset_requests_.end(), 0);
  begin(pending_.reset, id);
}

/// Resets the failed axes once all axes have been released.
void AxisGroup::judge_reset() noexcept {
  if (pending_.reset == 0 || joined_ > 0 || ending_) return;
  bool waits = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (axes_.axis(members_[i]).state() != PlcopenState::kErrorStop) continue;
    waits = true;
    auto& request = reset_requests_[i];
    if (request == 0) {
      request = axes_.submit_in_cycle(members_[i], {.command = AxisCommand::kReset});
    } else if (axes_.report(request).over()) {
      return finish(pending_.reset, RequestPhase::kError, GroupError::kResetFailed, members_[i]);
    }
  }
  if (waits) return;
  state_ = GroupState::kDisabled;
  failure_ = {};
  finish(pending_.reset, RequestPhase::kDone);
}

/// Handles a request to a led axis: the axis does not move on its own, but stops together with the group.
bool AxisGroup::take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept {
  const auto answer = [this, request](AxisError error) {
    const auto phase = error == AxisError::kNone ? RequestPhase::kDone : RequestPhase::kError;
    axes_.finish_in_cycle(request, {phase, error});
    return true;
  };
  if (asked.command == AxisCommand::kFollow) return answer(AxisError::kInGroup);
  if (!leads() || !axes_.axis(members_[axis]).follows()) return false;
  switch (asked.command) {
    case AxisCommand::kTouchProbe:
    case AxisCommand::kAbortTrigger:
    case AxisCommand::kReset:
      return false;
    case AxisCommand::kPower:
      if (asked.on) return false;
      break;
    case AxisCommand::kStop:
      break;
    case AxisCommand::kHalt:
      if (state_ == GroupState::kStopping) return answer(AxisError::kStopping);
      break;
    case AxisCommand::kReleaseStop:
      if (state_ != GroupState::kStopping) return answer(AxisError::kNothingToDo);
      release_stop();
      return answer(AxisError::kNone);
    default:
      return answer(AxisError::kInGroup);
  }
  stop_for(axis, request, asked);
  return true;
}

/// The request is answered when the group has come to rest.
void AxisGroup::stop_for(std::size_t place, std::uint64_t request, const AxisRequest& asked) noexcept {
  auto& waits = asked_[place];
  if (waits.id != 0) axes_.finish_in_cycle(waits.id, {RequestPhase::kAborted, AxisError::kNone});
  waits = {request, asked};
  axes_.finish_in_cycle(request, {RequestPhase::kActive, AxisError::kNone});
  if (state_ == GroupState::kErrorStop) return;
  if (asked.command == AxisCommand::kStop) state_ = GroupState::kStopping;
  finish(pending_.interrupt, RequestPhase::kAborted);
  end_path(table_.next(), GroupError::kAxisAsked, members_[place]);
}

}  // namespace driveline::motion
