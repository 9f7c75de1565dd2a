#pragma once

#include <tl/expected.hpp>

#include "boundary.hpp"
#include "brake.hpp"
#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// A requested motion, checked and prepared: the motion back inside the limits, and what remains to be done afterwards.
struct AxisTask {
  Brake brake;
  double brake_s;
  Boundary boundary;
  double way;        ///< displacement after the brake, divided by `scale`
  double way_error;  ///< rounding error of `way` from the positions, divided by `scale`
  double scale;      ///< the jerk limit, or 1 if there is none
  bool has_jerk_limit;
};

/// Prepares a motion to a position, velocity and acceleration.
[[nodiscard]] tl::expected<AxisTask, ProfileError> prepare_task(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                const ProfileLimits& limits) noexcept;

/// Appends phases to a profile, with accelerations and jerks times `scale`.
void append_phases(Profile& profile, const PhaseList& phases, double scale) noexcept;

}  // namespace driveline::trajectory
