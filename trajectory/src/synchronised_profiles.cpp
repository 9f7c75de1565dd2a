#include "driveline/trajectory/synchronised_profiles.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "driveline/trajectory/position_profile.hpp"

namespace driveline::trajectory {
namespace {

using Reason = ProfileError::Reason;

/// Relative difference below which durations are equal.
constexpr double kSameDuration = 1e-12;
/// Relative deviation of a velocity or an acceleration from the straight line that counts as rounding.
constexpr double kStraight = 1e-9;

tl::unexpected<AxisProfileError> fail(std::size_t axis, const ProfileError& error) noexcept {
  return tl::unexpected(AxisProfileError{axis, error});
}

/// Plans every axis separately; returns the longest duration.
tl::expected<double, AxisProfileError> plan_each(std::span<const AxisMotion> axes,
                                                 std::span<Profile> profiles) noexcept {
  double longest_s = 0.0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    auto profile = plan_to_position(axes[i].from, axes[i].to, axes[i].limits);
    if (!profile) {
      return fail(i, profile.error());
    }
    profiles[i] = *profile;
    longest_s = std::max(longest_s, profiles[i].duration_s());
  }
  return longest_s;
}

/// Makes all profiles end at the same time, which is later if that time is in a gap of an axis.
tl::expected<double, AxisProfileError> stretch_all(std::span<const AxisMotion> axes, std::span<Profile> profiles,
                                                   double duration_s) noexcept {
  // Every wait skips a gap of an axis permanently.
  std::size_t waits = PossibleDurations::kMaxGaps * axes.size();
  std::size_t axis = 0;
  for (std::size_t agreed = 0; agreed < axes.size();) {
    if (std::abs(profiles[axis].duration_s() - duration_s) > kSameDuration * duration_s) {
      const auto profile = plan_to_position(axes[axis].from, axes[axis].to, axes[axis].limits, duration_s);
      if (profile) {
        profiles[axis] = *profile;
      } else if (profile.error().reason == Reason::kBlocked && waits > 0) {
        --waits;
        duration_s = profile.error().possible_duration_s;
        agreed = 0;
        continue;
      } else {
        return fail(axis, profile.error());
      }
    }
    ++agreed;
    axis = (axis + 1) % axes.size();
  }
  return duration_s;
}

double way_of(const AxisMotion& axis) noexcept {
  return axis.to.position - axis.from.position;
}

bool is_multiple(double value, double factor, double of) noexcept {
  const double expected = factor * of;
  return std::abs(value - expected) <= kStraight * std::max(std::abs(value), std::abs(expected));
}

/// Converts the limits of an axis that moves `factor` times as far into limits of the motion on the line.
void tighten(ProfileLimits& line, const ProfileLimits& axis, double factor) noexcept {
  const bool turned = factor < 0.0;
  line.max_velocity = std::min(line.max_velocity, (turned ? axis.min_velocity : axis.max_velocity) / factor);
  line.min_velocity = std::max(line.min_velocity, (turned ? axis.max_velocity : axis.min_velocity) / factor);
  line.max_acceleration =
      std::min(line.max_acceleration, (turned ? axis.min_acceleration : axis.max_acceleration) / factor);
  line.min_acceleration =
      std::max(line.min_acceleration, (turned ? axis.max_acceleration : axis.min_acceleration) / factor);
  line.max_jerk = std::min(line.max_jerk, axis.max_jerk / std::abs(factor));
}

/// Plans all axes on a straight line; nullopt if there is no straight line, or no profile on it.
std::optional<double> plan_on_line(std::span<const AxisMotion> axes, std::span<Profile> profiles) noexcept {
  const AxisMotion& first = *std::max_element(axes.begin(), axes.end(), [](const AxisMotion& a, const AxisMotion& b) {
    return std::abs(way_of(a)) < std::abs(way_of(b));
  });
  const double way = way_of(first);
  if (!(std::abs(way) > 0.0)) {
    return std::nullopt;
  }
  ProfileLimits limits = first.limits;
  for (const AxisMotion& axis : axes) {
    const double factor = way_of(axis) / way;
    const bool is_straight = is_multiple(axis.from.velocity, factor, first.from.velocity) &&
                             is_multiple(axis.from.acceleration, factor, first.from.acceleration) &&
                             is_multiple(axis.to.velocity, factor, first.to.velocity) &&
                             is_multiple(axis.to.acceleration, factor, first.to.acceleration);
    if (!is_straight || !is_valid(axis.limits)) {
      return std::nullopt;
    }
    if (factor != 0.0) {
      tighten(limits, axis.limits, factor);
    }
  }
  const auto line = plan_to_position({0.0, first.from.velocity, first.from.acceleration},
                                     {way, first.to.velocity, first.to.acceleration}, limits);
  if (!line) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    profiles[i] = line->scaled(way_of(axes[i]) / way, axes[i].from, axes[i].to);
  }
  return line->duration_s();
}

}  // namespace

tl::expected<SynchronisedPlan, AxisProfileError> plan_synchronised(std::span<const AxisMotion> axes,
                                                                   Synchronisation synchronisation,
                                                                   std::span<Profile> profiles) noexcept {
  if (axes.empty() || axes.size() > kMaxSynchronisedAxes || profiles.size() != axes.size()) {
    return fail(0, {Reason::kAxes, 0.0});
  }
  if (synchronisation == Synchronisation::kPhase) {
    if (const auto duration_s = plan_on_line(axes, profiles)) {
      return SynchronisedPlan{Synchronisation::kPhase, *duration_s};
    }
    synchronisation = Synchronisation::kTime;
  }
  auto duration_s = plan_each(axes, profiles);
  if (duration_s && synchronisation == Synchronisation::kTime) {
    duration_s = stretch_all(axes, profiles, *duration_s);
  }
  if (!duration_s) {
    return tl::unexpected(duration_s.error());
  }
  return SynchronisedPlan{synchronisation, *duration_s};
}

}  // namespace driveline::trajectory
