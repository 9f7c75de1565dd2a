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

/// Requested motion of an axis in a set.
struct AxisMotion {
  AxisSetpoint from;     ///< start state
  AxisSetpoint to;       ///< target state
  ProfileLimits limits;  ///< limits of the axis
};

/// Relation between the motions of several axes.
enum class Synchronisation : std::uint8_t {
  kNone,   ///< each axis is as fast as possible
  kTime,   ///< all axes end together, as early as possible
  kPhase,  ///< all axes stay on a straight line at any time, as fast as the axes allow
};

/// Result of planning several axes.
struct SynchronisedPlan {
  Synchronisation synchronisation = Synchronisation::kNone;  ///< kTime instead of kPhase if there is no straight line
  double duration_s = 0.0;                                   ///< duration of the slowest axis

  /// Compares all fields. \rtsafe
  friend bool operator==(const SynchronisedPlan&, const SynchronisedPlan&) noexcept = default;
};

/// The axis that cannot be planned, and the reason.
struct AxisProfileError {
  std::size_t axis = 0;  ///< index in the list
  ProfileError error;    ///< the reason

  /// Compares all fields. \rtsafe
  friend bool operator==(const AxisProfileError&, const AxisProfileError&) noexcept = default;
};

/// Maximum number of axes planned together.
inline constexpr std::size_t kMaxSynchronisedAxes = 128;

/// Plans several axes. `profiles` has one element per axis and is complete only if there is no error. With kTime, gaps
/// between possible durations of an axis (possible_durations) make all axes wait until the end of the gap. With kPhase
/// the velocities and accelerations of both ends must be multiples of the displacement, with the same factor for all
/// axes within 1e-9; this holds for axes that move from rest to rest. A straight line may take longer than kTime.
/// The cost is bounded by 8 plans per axis and axis; it is two per axis unless there are gaps. \rtsafe
[[nodiscard]] tl::expected<SynchronisedPlan, AxisProfileError> plan_synchronised(std::span<const AxisMotion> axes,
                                                                                 Synchronisation synchronisation,
                                                                                 std::span<Profile> profiles) noexcept;

}  // namespace driveline::trajectory
