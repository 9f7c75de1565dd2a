#include "driveline/trajectory/velocity_profile.hpp"

#include <cmath>
#include <limits>

#include "profile/axis_task.hpp"
#include "profile/jerk_frontier.hpp"
#include "profile/trapezoid_frontier.hpp"

namespace driveline::trajectory {
namespace {

/// The fastest motion between the velocities and accelerations of a boundary.
template <typename Frontier>
PhaseList fastest_change(const Boundary& boundary) noexcept {
  const Frontier frontier(boundary);
  const auto stretch = frontier.has_short_stretch() ? frontier.short_stretch() : frontier.main_stretch();
  return stretch.phases(stretch.shortest());
}

}  // namespace

tl::expected<Profile, ProfileError> plan_to_velocity(const AxisSetpoint& from, double velocity, double acceleration,
                                                     const ProfileLimits& limits) noexcept {
  const AxisSetpoint to{from.position, velocity, acceleration};
  if (const auto task = prepare_task(from, to, limits); !task) {
    return tl::unexpected(task.error());
  }
  // A velocity outside the limits need not be brought back inside: the target is there.
  ProfileLimits free = limits;
  free.max_velocity = std::numeric_limits<double>::infinity();
  free.min_velocity = -free.max_velocity;
  const auto task = prepare_task(from, to, free);
  if (!task) {
    return tl::unexpected(task.error());
  }
  Profile profile(from);
  append_phases(profile, task->brake.phases, task->scale);
  append_phases(profile,
                task->has_jerk_limit ? fastest_change<JerkFrontier>(task->boundary)
                                     : fastest_change<TrapezoidFrontier>(task->boundary),
                task->scale);
  if (!(profile.duration_s() <= kLongestProfileSeconds) || !std::isfinite(profile.end().position)) {
    return tl::unexpected(ProfileError{ProfileError::Reason::kTooLong, 0.0});
  }
  profile.end_at({profile.end().position, velocity, acceleration});
  return profile;
}

tl::expected<Profile, ProfileError> plan_to_standstill(const AxisSetpoint& from, const ProfileLimits& limits) noexcept {
  return plan_to_velocity(from, 0.0, 0.0, limits);
}

}  // namespace driveline::trajectory
