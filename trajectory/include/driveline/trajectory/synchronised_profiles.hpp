#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// What one of several axes shall do.
struct AxisMotion {
  AxisSetpoint from;     ///< where it is
  AxisSetpoint to;       ///< where it shall be
  ProfileLimits limits;  ///< what it can do
};

/// How the motions of several axes belong together.
enum class Synchronisation : std::uint8_t {
  kNone,   ///< each axis is as fast as it can be
  kTime,   ///< all end together, as early as all can
  kPhase,  ///< all are on a straight line at any time, as fast as the axes allow on it
};

/// What has been planned.
struct SynchronisedPlan {
  Synchronisation synchronisation =
      Synchronisation::kNone;  ///< kTime where kPhase was asked for: there is no straight line
  double duration_s = 0.0;     ///< of the slowest axis

  /// \rtsafe
  friend bool operator==(const SynchronisedPlan&, const SynchronisedPlan&) noexcept = default;
};

/// Which axis cannot be planned, and why.
struct AxisProfileError {
  std::size_t axis = 0;  ///< its place in the list
  ProfileError error;    ///< what is wrong

  /// \rtsafe
  friend bool operator==(const AxisProfileError&, const AxisProfileError&) noexcept = default;
};

/// The most axes that are planned together.
inline constexpr std::size_t kMaxSynchronisedAxes = 128;

/// Plans several axes. `profiles` has a place for each of them and is complete only if there is no error. With kTime,
/// gaps between possible durations of an axis (possible_durations) make all wait until the end of the gap. With kPhase
/// the velocities and accelerations of both ends must be multiples of the way, with the same factor for all axes within
/// 1e-9; this is so for axes that go from rest to rest. A straight line may take longer than kTime does.
/// The cost is bounded by 8 plans per axis and axis; it is two per axis unless there are gaps. \rtsafe
[[nodiscard]] tl::expected<SynchronisedPlan, AxisProfileError> plan_synchronised(std::span<const AxisMotion> axes,
                                                                                 Synchronisation synchronisation,
                                                                                 std::span<Profile> profiles) noexcept;

}  // namespace driveline::trajectory
