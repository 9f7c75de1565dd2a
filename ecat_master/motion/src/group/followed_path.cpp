#include "followed_path.hpp"

#include <algorithm>
#include <utility>

namespace driveline::motion {
namespace {

/// Maximum number of moves settled in one cycle.
constexpr int kSettledPerCycle = 128;

}  // namespace

void FollowedPath::begin(GroupPath& path) noexcept {
  path_ = &path;
  place_ = {};
  completed_ = 0;
  active_move_ = 0;
  cycles_at_end_ = 0;
}

GroupPath* FollowedPath::leave() noexcept {
  place_ = {};
  return std::exchange(path_, nullptr);
}

void FollowedPath::step(std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  if (path_ == nullptr) return;
  completed_ = path_->completed();
  place_ = path_->step(setpoints);
}

void FollowedPath::settle_moves() noexcept {
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
  cycles_at_end_ = at_end ? cycles_at_end_ + 1 : 0;
}

void FollowedPath::abort_moves(GroupError error, std::size_t axis) noexcept {
  while (const auto request = next_request()) {
    table_.set(request, {RequestPhase::kAborted, error, axis});
    path_->settle_one();
  }
}

}  // namespace driveline::motion
