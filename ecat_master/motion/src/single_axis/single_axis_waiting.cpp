// Waiting motions of a single axis: when they start, and how the end of the previous motion is passed.
#include <algorithm>
#include <cmath>

#include "driveline/motion/single_axis/single_axis.hpp"
#include "driveline/trajectory/position_profile.hpp"

namespace driveline::motion {
namespace {

using trajectory::AxisSetpoint;

/// Number of velocities tried for passing a target, each half of the previous one; then the axis stops there.
constexpr int kPassages = 6;

trajectory::PositionRange between(double one, double other) noexcept {
  return {std::min(one, other), std::max(one, other)};
}

}  // namespace

/// How the end of a motion is passed; none: the axis stops there.
std::optional<SingleAxis::Passage> SingleAxis::passage_of(const Move& move) const noexcept {
  if (waiting_.empty() || !blends(waiting_.front().request.buffer)) return std::nullopt;
  if (!leads_to_position(waiting_.front().request.command)) return std::nullopt;
  auto next = waiting_.front();
  next.target = target_of(next.request, {move.target, 0.0, 0.0}, move.target);
  if (!in_range(next.target)) return std::nullopt;
  const double way = move.target - generator_.state().position;
  const double on = next.target - move.target;
  // The axis stops where it reverses.
  if (!(way * on > 0.0)) return std::nullopt;
  double velocity = std::copysign(passing_velocity(move, next), way);
  for (int i = 0; i < kPassages; ++i, velocity *= 0.5) {
    if (const auto way_on = way_behind(move, next, velocity)) return Passage{velocity, *way_on};
  }
  return std::nullopt;
}

/// Velocity that the buffer mode requests; never above that of the motion that ends.
double SingleAxis::passing_velocity(const Move& move, const Move& next) const noexcept {
  const double before = std::min(velocity_of(move.request) * override_, axis_->config().limits.max_velocity);
  const double after = std::min(velocity_of(next.request) * override_, axis_->config().limits.max_velocity);
  return next.request.buffer == BufferMode::kBlendingPrevious ? before : std::min(before, after);
}

/// Profile of the second motion, to rest, if neither motion has to reverse when the end of the first is passed at this
/// velocity.
std::optional<trajectory::Profile> SingleAxis::way_behind(const Move& move, const Move& next,
                                                          double velocity) const noexcept {
  const AxisSetpoint middle{move.target, velocity, 0.0};
  const auto& from = generator_.state();
  const auto first = trajectory::plan_to_position(from, middle, limits_of(move.request, velocity, from));
  const auto second =
      trajectory::plan_to_position(middle, {next.target, 0.0, 0.0}, limits_of(next.request, velocity, middle));
  const bool straight_on = first && second && trajectory::fits(*first, between(from.position, move.target)) &&
                           trajectory::fits(*second, between(move.target, next.target));
  return straight_on ? std::optional(*second) : std::nullopt;
}

/// Ends the motion under way. A waiting motion is planned in its turn; until then the ended one stays active, and the
/// axis stands at its end or continues at its velocity.
void SingleAxis::end_motion() noexcept {
  if (waiting_.empty()) {
    finish_move(RequestPhase::kDone);
    state_ = PlcopenState::kStandstill;
    return;
  }
  finish(active_->id, RequestPhase::kDone);
  if (!on_top_.active) finish(on_top_.request, RequestPhase::kDone);
  due_ = Due::kNext;
}

/// Passes the end of the motion under way along the profile that was planned with it, which ends at rest. If the end of
/// the next motion is to be passed as well, that is planned in its turn.
void SingleAxis::pass_end() noexcept {
  const double end = active_->target;
  finish_move(RequestPhase::kDone);
  active_ = waiting_.pop();
  active_->target = target_of(active_->request, {end, 0.0, 0.0}, end);
  last_target_ = active_->target;
  table_->set(active_->id, {RequestPhase::kActive, AxisError::kNone});
  if (!waiting_.empty() && blends(waiting_.front().request.buffer)) due_ = Due::kPassage;
}

void SingleAxis::plan_in_turn() noexcept {
  due_ == Due::kNext ? begin_next() : replan();
}

void SingleAxis::begin_next() noexcept {
  finish_move(RequestPhase::kDone);
  const auto next = waiting_.pop();
  const auto error = refusal_of_motion(next);
  if (error == AxisError::kNone) return begin_move(next);
  auto refused = next.id;
  finish(refused, RequestPhase::kError, error);
  drop_waiting(AxisError::kNone);
  begin_move({});
}

/// Appends a motion to the waiting ones; refuses it if the queue is full.
bool SingleAxis::keep_waiting(const Move& move) noexcept {
  if (waiting_.push(move)) return true;
  auto refused = move.id;
  finish(refused, RequestPhase::kError, AxisError::kBufferFull);
  return false;
}

}  // namespace driveline::motion
