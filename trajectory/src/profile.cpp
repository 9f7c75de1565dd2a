#include "driveline/trajectory/profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace driveline::trajectory {
namespace {

AxisSetpoint state_in(const Profile::Phase& phase, double t) noexcept {
  return {phase.displacement + t * (phase.velocity + t * (phase.acceleration / 2.0 + t * phase.jerk / 6.0)),
          phase.velocity + t * (phase.acceleration + t * phase.jerk / 2.0), phase.acceleration + t * phase.jerk};
}

/// Times since the start of a phase at which its velocity is zero; NaN or infinite if there is none.
std::array<double, 2> times_at_rest(const Profile::Phase& phase) noexcept {
  const double root = std::sqrt(phase.acceleration * phase.acceleration - 2.0 * phase.velocity * phase.jerk);
  const double q = -phase.acceleration - std::copysign(root, phase.acceleration);
  return {q / phase.jerk, 2.0 * phase.velocity / q};
}

}  // namespace

Profile::Profile(const AxisSetpoint& from) noexcept : start_position_(from.position), end_(from) {}

void Profile::append(double duration_s, double acceleration, double jerk) noexcept {
  if (!(duration_s > 0.0) || count_ == kMaxPhases) {
    return;
  }
  Phase& phase = phases_[count_++];
  phase = {duration_s_, end_displacement_, end_.velocity, acceleration, jerk};
  const AxisSetpoint after = state_in(phase, duration_s);
  duration_s_ += duration_s;
  end_displacement_ = after.position;
  end_ = {start_position_ + after.position, after.velocity, after.acceleration};
}

bool Profile::arrives_at(double position) const noexcept {
  double reach = std::abs(end_displacement_);
  for (std::size_t i = 0; i < count_; ++i) reach = std::max(reach, std::abs(phases_[i].displacement));
  const double rounding = 1e-6 * reach + 1e-9 * (std::abs(start_position_) + std::abs(position));
  return std::abs(start_position_ + end_displacement_ - position) <= rounding;
}

void Profile::end_at(const AxisSetpoint& to) noexcept {
  end_ = {to.position, to.velocity, to.acceleration};
}

Profile Profile::scaled(double factor, const AxisSetpoint& from, const AxisSetpoint& to) const noexcept {
  Profile profile = *this;
  profile.start_position_ = from.position;
  for (std::size_t i = 0; i < count_; ++i) {
    Phase& phase = profile.phases_[i];
    phase.displacement *= factor;
    phase.velocity *= factor;
    phase.acceleration *= factor;
    phase.jerk *= factor;
  }
  profile.end_displacement_ *= factor;
  profile.end_at(to);
  return profile;
}

AxisSetpoint Profile::evaluate(double elapsed_s) const noexcept {
  if (elapsed_s >= duration_s_) {
    const double behind_s = elapsed_s - duration_s_;
    if (behind_s == 0.0) {
      return end_;
    }
    return {end_.velocity == 0.0 ? end_.position : end_.position + behind_s * end_.velocity, end_.velocity, 0.0};
  }
  const double t = elapsed_s > 0.0 ? elapsed_s : 0.0;
  std::size_t i = 0;
  while (i + 1 < count_ && phases_[i + 1].begin_s <= t) {
    ++i;
  }
  AxisSetpoint setpoint = state_in(phases_[i], t - phases_[i].begin_s);
  setpoint.position += start_position_;
  return setpoint;
}

PositionRange Profile::extremes() const noexcept {
  PositionRange range{std::min(start_position_, end_.position), std::max(start_position_, end_.position)};
  for (std::size_t i = 0; i < count_; ++i) {
    const Phase& phase = phases_[i];
    const double length_s = (i + 1 < count_ ? phases_[i + 1].begin_s : duration_s_) - phase.begin_s;
    const std::array<double, 2> turns = times_at_rest(phase);
    for (const double t : {0.0, turns[0], turns[1]}) {
      if (t >= 0.0 && t <= length_s) {
        const double position = start_position_ + state_in(phase, t).position;
        range.min = std::min(range.min, position);
        range.max = std::max(range.max, position);
      }
    }
  }
  return range;
}

bool fits(const Profile& profile, const PositionRange& range) noexcept {
  const PositionRange way = profile.extremes();
  return way.min >= range.min && way.max <= range.max;
}

}  // namespace driveline::trajectory
