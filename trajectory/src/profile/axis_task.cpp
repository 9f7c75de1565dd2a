#include "axis_task.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Relative rounding error of a position: half of the last digit.
constexpr double kPositionRounding = 1.2e-16;

bool is_finite(const AxisSetpoint& state) noexcept {
  return std::isfinite(state.position) && std::isfinite(state.velocity) && std::isfinite(state.acceleration);
}

tl::unexpected<ProfileError> refuse(ProfileError::Reason reason) noexcept {
  return tl::unexpected(ProfileError{reason, 0.0});
}

bool is_within(double value, double limit) noexcept {
  return value <= limit * (1.0 + kRounding);
}

/// Whether a motion within the limits can end in the end state of the boundary.
bool can_end(const Boundary& b) noexcept {
  return is_within(b.a1, b.rise) && is_within(-b.a1, b.fall) && is_within(Boundary::highest(b.v1, -b.a1), b.top) &&
         is_within(Boundary::highest(-b.v1, b.a1), b.bottom);
}

/// Raises limits that the end states exceed by rounding, so that these are inside.
void enclose_ends(Boundary& b) noexcept {
  b.rise = std::max({b.rise, b.a0, b.a1});
  b.fall = std::max({b.fall, -b.a0, -b.a1});
  b.top = std::max(b.top, b.least_top());
  b.bottom = std::max(b.bottom, b.least_bottom());
}

}  // namespace

void append_phases(Profile& profile, const PhaseList& phases, double scale) noexcept {
  for (const JerkPhase& phase : phases) {
    profile.append(phase.duration_s, scale * phase.acceleration, scale * phase.jerk);
  }
}

tl::expected<AxisTask, ProfileError> prepare_task(const AxisSetpoint& from, const AxisSetpoint& to,
                                                  const ProfileLimits& limits) noexcept {
  if (!is_valid(limits)) {
    return refuse(ProfileError::Reason::kLimits);
  }
  if (!is_finite(from)) {
    return refuse(ProfileError::Reason::kState);
  }
  if (!is_finite(to)) {
    return refuse(ProfileError::Reason::kTarget);
  }
  AxisTask task;
  task.has_jerk_limit = std::isfinite(limits.max_jerk);
  task.scale = task.has_jerk_limit ? limits.max_jerk : 1.0;
  const double unit = 1.0 / task.scale;
  const double a0 = task.has_jerk_limit ? unit * from.acceleration : 0.0;
  const double a1 = task.has_jerk_limit ? unit * to.acceleration : 0.0;
  Boundary& b = task.boundary;
  b = {0.0,
       0.0,
       unit * to.velocity,
       a1,
       unit * limits.max_acceleration,
       -unit * limits.min_acceleration,
       unit * limits.max_velocity,
       -unit * limits.min_velocity};
  if (!can_end(b)) {
    return refuse(ProfileError::Reason::kTarget);
  }
  task.brake =
      task.has_jerk_limit ? brake_with_jerk(unit * from.velocity, a0, b) : brake_at_once(unit * from.velocity, b);
  b.v0 = task.brake.velocity;
  b.a0 = task.brake.acceleration;
  enclose_ends(b);
  task.brake_s = 0.0;
  task.way = unit * (to.position - from.position);
  task.way_error = unit * kPositionRounding * (std::abs(from.position) + std::abs(to.position));
  if (task.brake.phases.size() > 0) {
    Profile brake({0.0, from.velocity, 0.0});
    append_phases(brake, task.brake.phases, task.scale);
    task.brake_s = brake.duration_s();
    task.way -= unit * brake.end().position;
  }
  if (!std::isfinite(task.way) || !(task.brake_s <= kLongestProfileSeconds)) {
    return refuse(ProfileError::Reason::kTooLong);
  }
  return task;
}

}  // namespace driveline::trajectory
