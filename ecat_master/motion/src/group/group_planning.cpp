#include "group_planning.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace driveline::motion {

GroupPlanning::GroupPlanning(AxisGroup& group, GroupRequestTable& table, std::uint64_t grace_cycles, MakePath make_path,
                             Refuse refuse)
    : group_(group),
      table_(table),
      grace_cycles_(grace_cycles),
      make_path_(std::move(make_path)),
      refuse_(std::move(refuse)) {}

void GroupPlanning::add(std::deque<QueuedMove>& moves) {
  std::move(moves.begin(), moves.end(), std::back_inserter(waiting_));
  moves.clear();
}

void GroupPlanning::plan() {
  take_paths_back();
  leave_ended_path();
  drop_aborted();
  // Hand over first what did not fit into the path before.
  if (!hand_over()) return;
  while (true) {
    drop_aborted();
    if (waiting_.empty() || !group_.has_taken(waiting_.front().behind)) break;
    leave_ended_path();
    if (refuse_by_state()) continue;
    if (!ready_for(waiting_.front()) || !add_next()) return;
  }
  // The announced move has not come. The cycle keeps counting until it has seen the move that was added last.
  const auto at_end = group_.paths().cycles_at_end();
  if (at_end < at_end_when_added_) at_end_when_added_ = 0;
  if (path_ != nullptr && open_ && waiting_.empty() && at_end > at_end_when_added_ + grace_cycles_) {
    close_path();
    static_cast<void>(hand_over());
  }
}

void GroupPlanning::leave_ended_path() {
  if (path_ == nullptr || path_->epoch() > group_.paths().ended_epoch()) return;
  path_ = nullptr;
  open_ = false;
  closing_ = false;
}

void GroupPlanning::take_paths_back() {
  while (auto* const back = group_.paths().take_back()) {
    back->unsettled([this](std::uint64_t request) {
      table_.set(request, {RequestPhase::kAborted, GroupError::kNone, 0});
    });
    if (back == path_) path_ = nullptr;
    std::erase_if(paths_, [back](const auto& path) { return path.get() == back; });
  }
}

void GroupPlanning::drop_aborted() {
  const auto below = group_.paths().dropped_below();
  while (!waiting_.empty() && waiting_.front().id < below) {
    table_.set(waiting_.front().id, {RequestPhase::kAborted, GroupError::kNone, 0});
    waiting_.pop_front();
  }
}

/// Refuses the next move if the state of the group does not permit it; returns whether it did.
bool GroupPlanning::refuse_by_state() {
  auto error = GroupError::kNone;
  switch (group_.state()) {
    case GroupState::kDisabled:
      error = GroupError::kNotEnabled;
      break;
    case GroupState::kErrorStop:
      error = GroupError::kErrorStop;
      break;
    case GroupState::kStopping:
      error = GroupError::kStopping;
      break;
    case GroupState::kStandby:
    case GroupState::kMoving:
      return false;
  }
  table_.set(waiting_.front().id, {RequestPhase::kError, error, 0});
  waiting_.pop_front();
  return true;
}

/// Whether there is a path to which the move can be added.
bool GroupPlanning::ready_for(const QueuedMove& next) {
  if (path_ != nullptr && next.move.buffer == GroupBuffer::kAborting && !path_->idle()) {
    group_.paths().abort_for(next.id);
    return false;
  }
  if (path_ != nullptr) return path_->has_room();
  return begin_path();
}

/// Starts a path where the axes have come to rest.
bool GroupPlanning::begin_path() {
  const auto& standing = group_.standing();
  if (standing.epoch <= std::max(used_epoch_, group_.paths().ended_epoch())) return false;
  try {
    paths_.push_back(make_path_(standing));
  } catch (const std::invalid_argument& error) {
    refuse_next(error.what());
    return false;
  }
  path_ = paths_.back().get();
  used_epoch_ = standing.epoch;
  open_ = false;
  closing_ = false;
  group_.paths().offer(path_);
  return true;
}

/// Returns false if the path is full now.
bool GroupPlanning::add_next() {
  const auto move = absolute(waiting_.front().move);
  if (open_ && move.buffer != GroupBuffer::kBlending) path_->finish();
  if (auto added = path_->add(move); !added) {
    refuse_next(std::move(added.error().reason));
    if (open_) close_path();
    return hand_over();
  }
  path_->note(waiting_.front().id);
  waiting_.pop_front();
  open_ = true;
  at_end_when_added_ = group_.paths().cycles_at_end();
  if (!move.continues) close_path();
  return hand_over();
}

/// Refuses the next move, and aborts the moves that follow it, because they would start elsewhere.
void GroupPlanning::refuse_next(std::string reason) {
  const auto id = waiting_.front().id;
  // Store the reason before the error, so that a reader of the error finds it.
  refuse_(id, std::move(reason));
  table_.set(id, {RequestPhase::kError, GroupError::kBadMove, 0});
  waiting_.pop_front();
  while (!waiting_.empty() && waiting_.front().move.buffer != GroupBuffer::kAborting) {
    table_.set(waiting_.front().id, {RequestPhase::kAborted, GroupError::kBadMove, 0});
    waiting_.pop_front();
  }
}

void GroupPlanning::close_path() {
  path_->finish();
  open_ = false;
  closing_ = true;
}

bool GroupPlanning::hand_over() {
  if (path_ == nullptr) return true;
  if (!path_->flush()) return false;
  if (closing_) path_->complete();
  closing_ = false;
  return true;
}

GroupMove GroupPlanning::absolute(const GroupMove& move) const {
  auto made = move;
  if (!move.relative) return made;
  const auto from = path_->target();
  const auto shift = [from](auto& place) {
    for (std::size_t i = 0; i < std::min(from.size(), place.size()); ++i) place[i] += from[i];
  };
  shift(made.target);
  shift(made.path.target);
  shift(made.path.center);
  shift(made.path.via);
  for (auto& point : made.path.points) shift(point);
  made.relative = false;
  return made;
}

}  // namespace driveline::motion
