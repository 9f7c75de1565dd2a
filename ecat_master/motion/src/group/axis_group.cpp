// Cycle side of a group: its path and its states.
#include "axis_group.hpp"

#include <algorithm>
#include <utility>

namespace driveline::motion {

AxisGroup::AxisGroup(SingleAxes& axes, std::vector<std::size_t> members, GroupRequestTable& table)
    : axes_(axes),
      members_(std::move(members)),
      table_(table),
      inbox_(table),
      followed_(table),
      setpoints_(members_.size()),
      follow_requests_(members_.size()),
      reset_requests_(members_.size()),
      asked_(members_.size()) {}

const AxisGroup::Standing& AxisGroup::standing() noexcept {
  static_cast<void>(standings_.update());
  return standings_.read();
}

void AxisGroup::begin_cycle() noexcept {
  if (enabling_) {
    // All axes joined in the previous cycle.
    enabling_ = false;
    stand();
    finish(pending_.enable, RequestPhase::kDone);
  }
  watch();
  judge_path();
  judge_rest();
  judge_reset();
  inbox_.take([this](std::uint64_t id, const GroupRequest& request) noexcept { take(id, request); });
  take_path();
  publish();
}

void AxisGroup::join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept {
  setpoints_[axis] = {from.position, 0.0, 0.0};
  ++joined_;
}

void AxisGroup::leave(std::size_t /*axis*/) noexcept {
  if (joined_ > 0) --joined_;
}

bool AxisGroup::next(double /*period_s*/, std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  if (!leads()) return false;
  followed_.step(setpoints_);
  std::copy(setpoints_.begin(), setpoints_.end(), setpoints.begin());
  return true;
}

void AxisGroup::take_path() noexcept {
  auto* const path = paths_.take_offer();
  if (path == nullptr) return;
  const bool fits = !followed_.there() && leads() && path->epoch() == standing_.epoch &&
                    (state_ == GroupState::kStandby || state_ == GroupState::kMoving);
  if (!fits) return paths_.give_back(path);
  followed_.begin(*path);
  path->set_override(override_);
  set_hold();
}

void AxisGroup::set_hold() noexcept {
  if (followed_.there()) followed_.path().hold(interrupted_ || ending_);
}

/// Updates the progress of the moves.
void AxisGroup::judge_path() noexcept {
  if (!followed_.there()) return;
  const auto aborted_for = paths_.aborted_for();
  if (aborted_for != 0 && !ending_ && (state_ == GroupState::kMoving || state_ == GroupState::kStandby)) {
    return end_path(aborted_for, GroupError::kNone, 0);
  }
  if (ending_ || backwards_) return;
  followed_.settle_moves();
  const bool at_end = followed_.place().at_end;
  if (state_ == GroupState::kStandby && !at_end) state_ = GroupState::kMoving;
  if (state_ == GroupState::kMoving && at_end && followed_.next_request() == 0) state_ = GroupState::kStandby;
}

/// Completes what waits for the axes to be at standstill.
void AxisGroup::judge_rest() noexcept {
  if (state_ == GroupState::kDisabled) return;
  if (releasing_) {
    if (joined_ > 0) return;
    releasing_ = false;
    if (state_ != GroupState::kErrorStop) state_ = GroupState::kDisabled;
    finish(pending_.disable, RequestPhase::kDone);
    answer_asked(true);
    return;
  }
  const bool rests = !followed_.there() || followed_.place().at_rest || joined_ == 0;
  if (!rests) return;
  if (interrupted_) finish(pending_.interrupt, RequestPhase::kDone);
  if (ending_) {
    paths_.give_back(followed_.leave());
    ending_ = false;
    interrupted_ = false;
    backwards_ = false;
    stand();
    if (state_ == GroupState::kMoving) state_ = GroupState::kStandby;
  }
  if (followed_.there() && (pending_.stop != 0 || pending_.halt != 0 || pending_.disable != 0)) return;
  finish(pending_.stop, RequestPhase::kDone);
  finish(pending_.halt, RequestPhase::kDone);
  answer_asked(false);
  const bool wants_power_off =
      std::any_of(asked_.begin(), asked_.end(), [](const Asked& each) { return each.id != 0; });
  if (pending_.disable != 0 || wants_power_off || state_ == GroupState::kErrorStop) release();
}

/// Answers requests to the axes of a group that has come to rest, or has released its axes.
void AxisGroup::answer_asked(bool released) noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    auto& asked = asked_[i];
    if (asked.id == 0) continue;
    if (asked.request.command != AxisCommand::kPower) {
      axes_.finish_in_cycle(asked.id, {RequestPhase::kDone, AxisError::kNone});
    } else if (released) {
      axes_.pass_on_in_cycle(members_[i], asked.id, asked.request);
    } else {
      continue;
    }
    asked = {};
  }
}

/// Releases the axes at their present positions; they take requests of their own again.
void AxisGroup::release() noexcept {
  releasing_ = joined_ > 0;
  if (!releasing_) answer_asked(true);
}

/// Publishes the positions at which a path may start.
void AxisGroup::stand() noexcept {
  ++standing_.epoch;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    standing_.at[i] = setpoints_[i].position;
    standing_.offsets[i] = axes_.axis(members_[i]).position_offset();
  }
  standings_.write(standing_);
}

/// Ends the path: moves with numbers below `dropped_below` are aborted, and the axes come to rest on the path.
void AxisGroup::end_path(std::uint64_t dropped_below, GroupError error, std::size_t axis) noexcept {
  paths_.drop_below(dropped_below);
  if (ending_) return;
  ending_ = true;
  paths_.end_epoch(standing_.epoch);
  set_hold();
  followed_.abort_moves(error, axis);
}

void AxisGroup::watch() noexcept {
  if (!leads() || state_ == GroupState::kErrorStop) return;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!axes_.axis(members_[i]).follows()) return fail(i);
  }
}

/// Fails because of an axis: the others come to rest on the path; the failed axis is left to its drive.
void AxisGroup::fail(std::size_t axis) noexcept {
  const auto& one = axes_.axis(members_[axis]);
  state_ = GroupState::kErrorStop;
  failure_ = {GroupError::kAxisFailed, members_[axis], one.error(), one.error_code()};
  if (failure_.axis_error == AxisError::kNone) failure_.axis_error = axes_.report(follow_requests_[axis]).error;
  enabling_ = false;
  for (auto* const id : {&pending_.enable, &pending_.disable, &pending_.stop, &pending_.halt, &pending_.interrupt})
    finish(*id, RequestPhase::kError, GroupError::kAxisFailed, failure_.axis);
  end_path(table_.next(), GroupError::kAxisFailed, failure_.axis);
}

void AxisGroup::publish() noexcept {
  GroupReport report;
  report.state = state_;
  report.error = failure_.error;
  report.failed_axis = failure_.axis;
  report.axis_error = failure_.axis_error;
  report.error_code = failure_.error_code;
  report.override_factor = override_;
  report.speed = followed_.place().speed;
  report.length = followed_.place().length;
  report.move = followed_.place().at_end || ending_ ? 0 : followed_.next_request();
  report.interrupted = interrupted_;
  report.backwards = backwards_;
  paths_.set_cycles_at_end(followed_.there() && !backwards_ ? followed_.cycles_at_end() : 0);
  report_.write(report);
  // Last: planning that sees a request as taken finds the resulting state.
  inbox_.publish();
}

}  // namespace driveline::motion
