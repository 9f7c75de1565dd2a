#include "driveline/trajectory/position_profile.hpp"

#include <optional>

#include "driveline/trajectory/velocity_profile.hpp"
#include "profile/axis_task.hpp"
#include "profile/frontier_planner.hpp"
#include "profile/jerk_frontier.hpp"
#include "profile/trapezoid_frontier.hpp"

namespace driveline::trajectory {
namespace {

using Reason = ProfileError::Reason;

/// Calls `use` with the planner for a task.
template <typename Use>
auto with_planner(const AxisTask& task, Use use) noexcept {
  return task.has_jerk_limit ? use(FrontierPlanner<JerkFrontier>(task.boundary, task.way, task.way_error))
                             : use(FrontierPlanner<TrapezoidFrontier>(task.boundary, task.way, task.way_error));
}

/// A profile that contains only the motion back inside the limits. Profiles are large, so this one is built in place.
tl::expected<Profile, ProfileError> begin(const AxisTask& task, const AxisSetpoint& from) noexcept {
  tl::expected<Profile, ProfileError> profile(tl::in_place, from);
  append_phases(*profile, task.brake.phases, task.scale);
  return profile;
}

void finish(tl::expected<Profile, ProfileError>& profile, const AxisSetpoint& to) noexcept {
  if (!(profile->duration_s() <= kLongestProfileSeconds) || !profile->arrives_at(to.position)) {
    profile = tl::unexpected(ProfileError{Reason::kTooLong, 0.0});
  } else {
    profile->end_at(to);
  }
}

/// Smallest relative length of a gap between durations.
constexpr double kSmallestGap = 1e-8;
/// Iteration limit above the number of gap ends of the frontiers, spurious ones included.
constexpr int kMaxEnds = 16;

}  // namespace

tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                     const ProfileLimits& limits) noexcept {
  const auto task = prepare_task(from, to, limits);
  if (!task) {
    return tl::unexpected(task.error());
  }
  auto profile = begin(*task, from);
  with_planner(*task, [&](const auto& planner) {
    const auto fastest = planner.fastest();
    append_phases(*profile, fastest.phases, fastest.sign * task->scale);
  });
  finish(profile, to);
  return profile;
}

tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                     const ProfileLimits& limits, double duration_s) noexcept {
  const auto task = prepare_task(from, to, limits);
  if (!task) {
    return tl::unexpected(task.error());
  }
  if (!(duration_s <= kLongestProfileSeconds)) {
    return tl::unexpected(ProfileError{Reason::kTooLong, 0.0});
  }
  auto profile = begin(*task, from);
  const double rest_s = duration_s - task->brake_s;
  const auto refusal = with_planner(*task, [&](const auto& planner) -> std::optional<ProfileError> {
    const double possible_s = planner.next_possible_s(rest_s);
    if (possible_s - rest_s > kRounding * duration_s) {
      const bool is_short = rest_s < planner.next_possible_s(0.0);
      return ProfileError{is_short ? Reason::kTooShort : Reason::kBlocked, task->brake_s + possible_s};
    }
    planner.append_mixture(*profile, possible_s, task->scale);
    return std::nullopt;
  });
  if (refusal) {
    profile = tl::unexpected(*refusal);
  } else {
    finish(profile, to);
  }
  return profile;
}

tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                     const ProfileLimits& limits, const PositionRange& range,
                                                     OutOfRange otherwise) noexcept {
  const auto profile = plan_to_position(from, to, limits);
  if (!profile || fits(*profile, range)) {
    return profile;
  }
  if (otherwise == OutOfRange::kBrake) {
    return plan_to_standstill(from, limits);
  }
  return tl::unexpected(ProfileError{Reason::kPositionRange, 0.0});
}

tl::expected<PossibleDurations, ProfileError> possible_durations(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                 const ProfileLimits& limits) noexcept {
  const auto task = prepare_task(from, to, limits);
  if (!task) {
    return tl::unexpected(task.error());
  }
  PossibleDurations durations;
  with_planner(*task, [&](const auto& planner) {
    double possible_s = planner.next_possible_s(0.0);
    durations.shortest_s_ = task->brake_s + possible_s;
    for (int i = 0; i < kMaxEnds && durations.count_ < PossibleDurations::kMaxGaps; ++i) {
      // At an end of a gap, rounding decides on which side it lies.
      const double probe_s = possible_s * (1.0 + kSmallestGap);
      const double next_s = planner.next_impossible_s(probe_s);
      const double begin_s = next_s > probe_s ? next_s : possible_s;
      if (!(begin_s <= kLongestProfileSeconds)) {
        break;
      }
      possible_s = planner.next_possible_s(begin_s * (1.0 + kSmallestGap));
      if (possible_s > begin_s * (1.0 + 2.0 * kSmallestGap)) {
        durations.gaps_[durations.count_++] = {task->brake_s + begin_s, task->brake_s + possible_s};
      }
    }
  });
  if (!(durations.shortest_s_ <= kLongestProfileSeconds)) {
    return tl::unexpected(ProfileError{Reason::kTooLong, 0.0});
  }
  return durations;
}

}  // namespace driveline::trajectory
