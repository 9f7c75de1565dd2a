#pragma once

#include <tl/expected.hpp>

#include "boundary.hpp"
#include "brake.hpp"
#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// A motion that was asked for, checked and prepared: the way back inside the limits, and what is left to do then.
struct AxisTask {
  Brake brake;
  double brake_s;
  Boundary boundary;
  double way;        ///< behind the brake, divided by `scale`
  double way_error;  ///< by rounding of the positions, divided by `scale`
  double scale;      ///< the jerk limit, or 1 if there is none
  bool has_jerk_limit;
};

/// To a position, velocity and acceleration.
[[nodiscard]] tl::expected<AxisTask, ProfileError> prepare_task(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                const ProfileLimits& limits) noexcept;

/// Appends phases to a profile, accelerations and jerks times `scale`.
void append_phases(Profile& profile, const PhaseList& phases, double scale) noexcept;

}  // namespace driveline::trajectory
