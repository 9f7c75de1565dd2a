// Cycle side of a group: its path and its states.
#include "axis_group.hpp"

#include <algorithm>
#include <utility>

namespace driveline::motion {
namespace {

constexpr std::size_t kRequests = 256;
/// Capacity of the queue of returned paths; planning offers one at a time.
constexpr std::size_t kReturned = 8;
/// Maximum number of moves settled in one cycle.
constexpr int kSettledPerCycle = 128;

}  // namespace

AxisGroup::AxisGroup(SingleAxes& axes, std::vector<std::size_t> members, GroupRequestTable& table)
    : axes_(axes),
      members_(std::move(members)),
      table_(table),
      setpoints_(members_.size()),
      follow_requests_(members_.size()),
      reset_requests_(members_.size()),
      asked_(members_.size()),
      requests_(kRequests),
      returned_(kReturned) {}

std::uint64_t AxisGroup::submit(const GroupRequest& request) noexcept {
  if (const auto kind = group_stop(request.command)) {
    const auto id = table_.add();
    const auto replaced = stops_.put(0, *kind, {id, request});
    table_.set_if_waiting(replaced, {RequestPhase::kAborted, GroupError::kNone, 0});
    return id;
  }
  if (requests_.size() >= requests_.capacity()) return 0;
  const auto id = table_.add();
  requests_.try_push({id, request});
  ++queued_;
  return id;
}

GroupPath* AxisGroup::take_back() noexcept {
  GroupPath* path = nullptr;
  return returned_.try_pop(path) ? path : nullptr;
}

const AxisGroup::Standing& AxisGroup::standing() noexcept {
  static_cast<void>(standings_.update());
  return standings_.read();
}

GroupReport AxisGroup::report() const noexcept {
  GroupReport report;
  report.state = shared_state_.load(std::memory_order_acquire);
  report.error = shared_error_.load(std::memory_order_relaxed);
  report.failed_axis = shared_failed_axis_.load(std::memory_order_relaxed);
  report.axis_error = shared_axis_error_.load(std::memory_order_relaxed);
  report.error_code = shared_error_code_.load(std::memory_order_relaxed);
  report.override_factor = shared_override_.load(std::memory_order_relaxed);
  report.speed = shared_speed_.load(std::memory_order_relaxed);
  report.length = shared_length_.load(std::memory_order_relaxed);
  report.move = shared_move_.load(std::memory_order_relaxed);
  report.interrupted = shared_interrupted_.load(std::memory_order_relaxed);
  report.backwards = shared_backwards_.load(std::memory_order_relaxed);
  return report;
}

void AxisGroup::begin_cycle() noexcept {
  if (enabling_) {
    // All axes joined in the previous cycle.
    enabling_ = false;
    stand();
    finish(enable_request_, RequestPhase::kDone);
  }
  watch();
  judge_path();
  judge_rest();
  judge_reset();
  take_stops();
  take_requests();
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
  step();
  std::copy(setpoints_.begin(), setpoints_.end(), setpoints.begin());
  return true;
}

void AxisGroup::step() noexcept {
  if (path_ == nullptr) return;
  completed_ = path_->completed();
  place_ = path_->step(setpoints_);
}

void AxisGroup::take_path() noexcept {
  if (offered_.load(std::memory_order_relaxed) == nullptr) return;
  auto* const path = offered_.exchange(nullptr, std::memory_order_acquire);
  const bool fits = path_ == nullptr && leads() && path->epoch() == standing_.epoch &&
                    (state_ == GroupState::kStandby || state_ == GroupState::kMoving);
  if (!fits) {
    static_cast<void>(returned_.try_push(path));
    return;
  }
  path_ = path;
  place_ = {};
  completed_ = 0;
  active_move_ = 0;
  at_end_for_ = 0;
  path_->set_override(override_);
  set_hold();
}

void AxisGroup::set_hold() noexcept {
  if (path_ != nullptr) path_->hold(interrupted_ || ending_);
}

/// Updates the progress of the moves.
void AxisGroup::judge_path() noexcept {
  if (path_ == nullptr) return;
  const auto aborted_for = abort_for_.load(std::memory_order_acquire);
  if (aborted_for > dropped_below_.load(std::memory_order_relaxed) && !ending_ &&
      (state_ == GroupState::kMoving || state_ == GroupState::kStandby)) {
    return end_path(aborted_for, GroupError::kNone, 0);
  }
  if (ending_ || backwards_) return;
  const bool at_end = place_.at_end;
  const auto done = at_end ? std::max(completed_, place_.move) : place_.move;
  for (int i = 0; i < kSettledPerCycle && path_->done() < done; ++i) {
    table_.set(path_->next_request(), {RequestPhase::kDone, GroupError::kNone, 0});
    path_->settle_one();
  }
  if (!at_end && path_->done() == place_.move && active_move_ <= place_.move) {
    table_.set(path_->next_request(), {RequestPhase::kActive, GroupError::kNone, 0});
    active_move_ = place_.move + 1;
  }
  at_end_for_ = at_end ? at_end_for_ + 1 : 0;
  if (state_ == GroupState::kStandby && !at_end) state_ = GroupState::kMoving;
  if (state_ == GroupState::kMoving && at_end && path_->next_request() == 0) state_ = GroupState::kStandby;
}

/// Completes what waits for the axes to be at standstill.
void AxisGroup::judge_rest() noexcept {
  if (state_ == GroupState::kDisabled) return;
  if (releasing_) {
    if (joined_ > 0) return;
    releasing_ = false;
    if (state_ != GroupState::kErrorStop) state_ = GroupState::kDisabled;
    finish(disable_request_, RequestPhase::kDone);
    answer_asked(true);
    return;
  }
  const bool rests = path_ == nullptr || place_.at_rest || joined_ == 0;
  if (!rests) return;
  if (interrupted_) finish(interrupt_request_, RequestPhase::kDone);
  if (ending_) {
    if (path_ != nullptr) static_cast<void>(returned_.try_push(path_));
    path_ = nullptr;
    place_ = {};
    ending_ = false;
    interrupted_ = false;
    backwards_ = false;
    stand();
    if (state_ == GroupState::kMoving) state_ = GroupState::kStandby;
  }
  if (path_ != nullptr && (stop_request_ != 0 || halt_request_ != 0 || disable_request_ != 0)) return;
  finish(stop_request_, RequestPhase::kDone);
  finish(halt_request_, RequestPhase::kDone);
  answer_asked(false);
  const bool wants_power_off =
      std::any_of(asked_.begin(), asked_.end(), [](const Asked& each) { return each.id != 0; });
  if (disable_request_ != 0 || wants_power_off || state_ == GroupState::kErrorStop) release();
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
  dropped_below_.store(dropped_below, std::memory_order_release);
  if (ending_) return;
  ending_ = true;
  ended_epoch_.store(standing_.epoch, std::memory_order_release);
  set_hold();
  if (path_ == nullptr) return;
  while (const auto request = path_->next_request()) {
    table_.set(request, {RequestPhase::kAborted, error, axis});
    path_->settle_one();
  }
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
  error_ = GroupError::kAxisFailed;
  failed_axis_ = members_[axis];
  axis_error_ = one.error();
  if (axis_error_ == AxisError::kNone) axis_error_ = axes_.report(follow_requests_[axis]).error;
  error_code_ = one.error_code();
  enabling_ = false;
  for (auto* const id : {&enable_request_, &disable_request_, &stop_request_, &halt_request_, &interrupt_request_})
    finish(*id, RequestPhase::kError, GroupError::kAxisFailed, failed_axis_);
  end_path(table_.next(), GroupError::kAxisFailed, failed_axis_);
}

void AxisGroup::publish() noexcept {
  shared_error_.store(error_, std::memory_order_relaxed);
  shared_failed_axis_.store(failed_axis_, std::memory_order_relaxed);
  shared_axis_error_.store(axis_error_, std::memory_order_relaxed);
  shared_error_code_.store(error_code_, std::memory_order_relaxed);
  shared_override_.store(override_, std::memory_order_relaxed);
  shared_speed_.store(place_.speed, std::memory_order_relaxed);
  shared_length_.store(place_.length, std::memory_order_relaxed);
  const bool moves = path_ != nullptr && !place_.at_end && !ending_;
  shared_move_.store(moves ? path_->next_request() : 0, std::memory_order_relaxed);
  shared_interrupted_.store(interrupted_, std::memory_order_relaxed);
  shared_backwards_.store(backwards_, std::memory_order_relaxed);
  cycles_at_end_.store(path_ != nullptr && !backwards_ ? at_end_for_ : 0, std::memory_order_release);
  // Publish these last: a reader of GroupErrorStop finds its reason, and planning that sees a request as taken finds
  // the resulting state.
  shared_state_.store(state_, std::memory_order_release);
  taken_.store(taken_now_, std::memory_order_release);
  stops_taken_.store(stops_.puts_taken(), std::memory_order_release);
}

}  // namespace driveline::motion
