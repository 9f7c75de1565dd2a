#include "line_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/profile_limits.hpp"

namespace driveline::motion {
namespace {

using trajectory::AxisSetpoint;
using trajectory::GroupAxisLimits;

/// The same values as in trajectory::PathShaper.
constexpr double kFarthest = 1e6;
constexpr double kShortestMove = 1e-9;

trajectory::ProfileLimits within(const GroupAxisLimits& limits, double velocity) noexcept {
  return trajectory::ProfileLimits::symmetric(velocity, limits.max_acceleration, limits.max_jerk);
}

}  // namespace

LinePath::LinePath(std::vector<GroupAxisLimits> limits, RangeCheck ranges, double period_s,
                   std::span<const double> start, std::uint64_t epoch)
    : GroupPath(epoch),
      limits_(std::move(limits)),
      ranges_(std::move(ranges)),
      target_(start.begin(), start.end()),
      lines_(kLines),
      period_s_(period_s),
      rest_(target_) {
  for (auto& line : lines_) {
    line.from.resize(target_.size());
    line.to.resize(target_.size());
  }
}

tl::expected<void, trajectory::PathMoveError> LinePath::check(const GroupMove& move) const {
  const auto bad = [](std::string reason) { return tl::unexpected(trajectory::PathMoveError{std::move(reason)}); };
  if (move.path.kind != trajectory::PathMove::Kind::kLine)
    return bad("a group of more than " + std::to_string(trajectory::kMaxGroupAxes) + " axes moves along lines only");
  if (move.path.dwell_s != 0.0 || !move.path.outputs.empty())
    return bad("a group of more than " + std::to_string(trajectory::kMaxGroupAxes) + " axes has no dwells or outputs");
  if (move.path.tolerance > 0.0)
    return bad("a group of more than " + std::to_string(trajectory::kMaxGroupAxes) +
               " axes stops between its moves: corners cannot be blended");
  if (move.target.size() != target_.size()) return tl::unexpected(wrong_count(move.target.size(), target_.size()));
  if (!(move.path.feed > 0.0)) return bad("the feed is " + std::to_string(move.path.feed) + "; it must be above 0");
  for (std::size_t i = 0; i < target_.size(); ++i) {
    if (std::abs(move.target[i]) <= kFarthest) continue;
    return bad("the target of axis " + std::to_string(i + 1) + " is " + std::to_string(move.target[i]) +
               "; positions lie within +-1e6 m or rad");
  }
  return ranges_.place(move.target);
}

tl::expected<void, trajectory::PathMoveError> LinePath::add(const GroupMove& move) {
  if (auto checked = check(move); !checked) return checked;
  auto line = line_to(move.target, move.path.feed);
  if (line.length > kShortestMove) {
    const double feed = std::min(line.feed, line.limits.max_velocity);
    if (!trajectory::plan_to_position({}, {line.length, 0.0, 0.0}, within(line.limits, feed)))
      return tl::unexpected(trajectory::PathMoveError{"with that feed it would take more than 100000 s"});
    line.move = moves_;
    target_ = move.target;
    waiting_.push_back(std::move(line));
  }
  ++moves_;
  return {};
}

/// Line from the last target. Its limits are those of the axis that reaches its own limit first.
LinePath::Line LinePath::line_to(std::span<const double> target, double feed) const {
  Line line;
  line.from = target_;
  line.to.assign(target.begin(), target.end());
  line.feed = feed;
  for (std::size_t i = 0; i < target_.size(); ++i) line.length = std::hypot(line.length, target[i] - target_[i]);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  line.limits = {kNone, kNone, kNone};
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double share = std::abs(target[i] - target_[i]) / line.length;
    if (!(share > 0.0)) continue;
    line.limits.max_velocity = std::min(line.limits.max_velocity, limits_[i].max_velocity / share);
    line.limits.max_acceleration = std::min(line.limits.max_acceleration, limits_[i].max_acceleration / share);
    line.limits.max_jerk = std::min(line.limits.max_jerk, limits_[i].max_jerk / share);
  }
  return line;
}

bool LinePath::flush() {
  auto end = end_.load(std::memory_order_relaxed);
  const auto begin = begin_.load(std::memory_order_acquire);
  while (!waiting_.empty() && end - begin < kLines) {
    lines_[end++ % kLines] = std::move(waiting_.front());
    waiting_.pop_front();
    end_.store(end, std::memory_order_release);
  }
  return waiting_.empty();
}

void LinePath::set_override(double share) noexcept {
  planned_ = planned_ && share == override_;
  override_ = share;
}

void LinePath::hold(bool held) noexcept {
  planned_ = planned_ && held == held_;
  held_ = held;
}

void LinePath::reverse(bool backwards) noexcept {
  planned_ = planned_ && backwards == backwards_;
  backwards_ = backwards;
}

/// Whether the axes are at the end of the line, in the requested direction.
bool LinePath::arrived() const noexcept {
  if (!planned_ || !along_.finished()) return false;
  return along_.state().position == (backwards_ ? 0.0 : line().length);
}

void LinePath::begin_next() noexcept {
  if (on_line_) {
    length_before_ += line().length;
    begin_.store(++line_, std::memory_order_release);
  }
  on_line_ = true;
  along_.start_from({});
  planned_ = false;
}

// At an override too low for planning the axes stop until it changes.
void LinePath::plan() noexcept {
  const auto& limits = line().limits;
  const double feed = std::min(override_ * line().feed, limits.max_velocity);
  planned_ = true;
  const bool goes = !held_ && feed > 0.0;
  if (goes && along_.to_position({backwards_ ? 0.0 : line().length, 0.0, 0.0}, within(limits, feed))) return;
  static_cast<void>(along_.to_velocity(0.0, within(limits, limits.max_velocity)));
}

GroupPath::Place LinePath::step(std::span<AxisSetpoint> setpoints) noexcept {
  const bool forwards = !held_ && !backwards_;
  const bool next = on_line_ ? forwards && arrived() && line_ + 1 < end_.load(std::memory_order_acquire) : has_line();
  if (next) begin_next();
  if (!on_line_) {
    for (std::size_t i = 0; i < rest_.size(); ++i) setpoints[i] = {rest_[i], 0.0, 0.0};
    return {};
  }
  if (!planned_) plan();
  along_.advance(period_s_);
  place_axes(setpoints);
  Place place;
  place.move = line().move;
  place.length = length_before_ + along_.state().position;
  place.speed = along_.state().velocity;
  place.at_rest = along_.finished();
  place.at_end = arrived() && (backwards_ || line_ + 1 >= end_.load(std::memory_order_acquire));
  return place;
}

void LinePath::place_axes(std::span<AxisSetpoint> setpoints) const noexcept {
  const auto& on = line();
  const auto& at = along_.state();
  const double rest = on.length - at.position;
  for (std::size_t i = 0; i < on.from.size(); ++i) {
    const double way = (on.to[i] - on.from[i]) / on.length;
    // Computed from the nearer end, so that both ends are met exactly.
    const double position = at.position < rest ? on.from[i] + way * at.position : on.to[i] - way * rest;
    setpoints[i] = {position, way * at.velocity, way * at.acceleration};
  }
}

}  // namespace driveline::motion
