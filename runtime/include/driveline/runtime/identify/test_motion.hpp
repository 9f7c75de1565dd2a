#pragma once

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::runtime {

/// Motion that identifies the load of an axis: back and forth, at several speeds, with pauses in between.
struct TestMotion {
  double distance = 0.0;      ///< rad or m, from the start position; not 0; negative: in negative direction
  double velocity = 0.0;      ///< highest velocity, rad/s or m/s; above 0
  double acceleration = 0.0;  ///< highest acceleration, rad/s^2 or m/s^2; above 0
};

/// Returns the motion as a path of a single axis that starts at 0. Errors (kSetting): outside the limits of the axis,
/// distance 0, or a duration of hours.
[[nodiscard]] Result<trajectory::Interpolator> make_test_path(const TestMotion& motion, const motion::AxisConfig& axis);

}  // namespace driveline::runtime
