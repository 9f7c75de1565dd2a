#pragma once

#include <tl/expected.hpp>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Plans the fastest change of an axis to a velocity (rad/s or m/s) and an acceleration (rad/s^2 or m/s^2), at any
/// position. A start acceleration outside the limits is first brought back inside. With an infinite jerk limit the
/// accelerations at both ends are ignored. Bounded cost, no allocation. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_velocity(const AxisSetpoint& from, double velocity,
                                                                   double acceleration,
                                                                   const ProfileLimits& limits) noexcept;

/// Plans the fastest stop. Like StopProfile, with limits that may differ between the directions. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_standstill(const AxisSetpoint& from,
                                                                     const ProfileLimits& limits) noexcept;

}  // namespace driveline::trajectory
