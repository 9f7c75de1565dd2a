#include "driveline/trajectory/setpoint_stream.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "driveline/trajectory/path.hpp"

namespace driveline::trajectory {
namespace {

bool is_positive(double value) {
  return value > 0.0 && std::isfinite(value);
}

void require_possible(bool possible, const char* what) {
  if (!possible) throw std::invalid_argument(what);
}

const StreamSettings& checked(const StreamSettings& settings, std::span<const FollowLimits> limits) {
  require_possible(!limits.empty() && limits.size() <= kMaxPathAxes, "a stream has 1 to 256 axes");
  require_possible(is_positive(settings.period_s) && is_positive(settings.max_gap_s) &&
                       is_positive(settings.max_ahead_s) && settings.delay_s >= 0.0 && std::isfinite(settings.delay_s),
                   "the times of a stream must be finite and positive");
  require_possible(settings.capacity > facts_of(settings.method).delay,
                   "a stream must have room for more setpoints than its method needs");
  for (const auto& limit : limits) {
    require_possible(
        is_positive(limit.motion.max_velocity) && is_positive(limit.motion.max_acceleration) && limit.max_jerk > 0.0,
        "the limits of an axis must be positive and finite");
  }
  return settings;
}

bool is_finite(const StreamPoint& point) {
  return std::isfinite(point.position) && std::isfinite(point.velocity) && std::isfinite(point.acceleration);
}

bool is_in_range(const StreamPoint& point) {
  return std::abs(point.position) <= kMaxPathPosition && std::abs(point.velocity) <= kMaxPathVelocity &&
         std::abs(point.acceleration) <= kMaxPathAcceleration;
}

}  // namespace

SetpointStream::SetpointStream(const StreamSettings& settings, std::span<const FollowLimits> limits)
    : settings_(checked(settings, limits)),
      curve_(settings.method, limits.size(), settings.capacity, settings.max_gap_s),
      targets_(limits.size()) {
  for (const auto& limit : limits) axes_.emplace_back(limit, settings.period_s);
}

void SetpointStream::begin(double now_s, std::span<const double> positions) noexcept {
  curve_.clear();
  for (std::size_t i = 0; i < std::min(axes_.size(), positions.size()); ++i) axes_[i].rest_at(positions[i]);
  state_ = StreamState::kAtRest;
  coasted_ = 0;
  running_ = true;
  now_s_ = now_s;
  newest_s_ = -std::numeric_limits<double>::infinity();
}

StreamVerdict SetpointStream::push(double time_s, std::span<const StreamPoint> points) noexcept {
  const StreamVerdict verdict = judge(time_s, points);
  ++counters_.verdicts[static_cast<std::size_t>(verdict)];
  if (verdict == StreamVerdict::kAccepted) {
    if (leaves_gap(time_s)) curve_.clear();
    curve_.add(time_s, points);
    newest_s_ = time_s;
  }
  return verdict;
}

StreamVerdict SetpointStream::judge(double time_s, std::span<const StreamPoint> points) const noexcept {
  if (points.size() != axes_.size()) return StreamVerdict::kWrongCount;
  if (!std::isfinite(time_s) || !std::all_of(points.begin(), points.end(), is_finite)) return StreamVerdict::kNotFinite;
  if (!std::all_of(points.begin(), points.end(), is_in_range)) return StreamVerdict::kOutOfRange;
  return judge_time(time_s);
}

StreamVerdict SetpointStream::judge_time(double time_s) const noexcept {
  if (std::abs(time_s - newest_s_) < kMinPathStepS) return StreamVerdict::kDuplicate;
  if (time_s < newest_s_) return StreamVerdict::kOutOfOrder;
  if (time_s < now_s_ - settings_.delay_s) return StreamVerdict::kTooLate;
  if (time_s > now_s_ + settings_.max_ahead_s) return StreamVerdict::kTooFarAhead;
  const bool ran_out = newest_s_ < now_s_ - settings_.delay_s && !follows();
  if (leaves_gap(time_s) && !ran_out) return StreamVerdict::kGapTooLarge;
  return curve_.full() ? StreamVerdict::kOverrun : StreamVerdict::kAccepted;
}

/// `reached`: the curve extends to the present.
StreamState SetpointStream::next_state(bool reached) noexcept {
  if (running_ && reached) {
    coasted_ = 0;
    return StreamState::kFollowing;
  }
  if (state_ == StreamState::kFollowing && running_) ++counters_.underruns;
  if (running_ && follows() && coasted_ < settings_.coast_cycles) {
    ++coasted_;
    return StreamState::kCoasting;
  }
  if (follows() && running_) ++counters_.stops;
  if (follows()) return StreamState::kStopping;
  const bool rest = std::all_of(axes_.begin(), axes_.end(), [](const LimitedAxis& axis) { return axis.at_rest(); });
  return rest ? StreamState::kAtRest : StreamState::kStopping;
}

StreamState SetpointStream::evaluate(double now_s, std::span<AxisSetpoint> out) noexcept {
  if (now_s > now_s_ && std::isfinite(now_s)) now_s_ = now_s;
  const double curve_s = now_s_ - settings_.delay_s;
  state_ = next_state(curve_.advance(curve_s));
  const std::size_t count = std::min(out.size(), axes_.size());
  if (!follows()) {
    for (std::size_t i = 0; i < axes_.size(); ++i) targets_[i] = axes_[i].stop();
  } else {
    curve_.evaluate(curve_s, targets_);
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const bool was_on_curve = axes_[i].on_target();
      targets_[i] = axes_[i].follow(targets_[i]);
      if (was_on_curve && !axes_[i].on_target()) ++counters_.detours;
    }
  }
  std::copy_n(targets_.begin(), count, out.begin());
  return state_;
}

bool SetpointStream::on_curve() const noexcept {
  return follows() && std::all_of(axes_.begin(), axes_.end(), [](const LimitedAxis& axis) { return axis.on_target(); });
}

}  // namespace driveline::trajectory
