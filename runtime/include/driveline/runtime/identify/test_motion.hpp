#pragma once

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::runtime {

/// The motion by which the load of an axis is found: to and fro, at several speeds, with rests in between.
struct TestMotion {
  double distance = 0.0;      ///< rad or m, from where the axis stands; not 0, negative: in negative direction
  double velocity = 0.0;      ///< highest, rad/s or m/s; above 0
  double acceleration = 0.0;  ///< highest, rad/s^2 or m/s^2; above 0
};

/// As a path of one axis that begins at 0. Errors (kSetting): beyond the limits of the axis, a way of length 0 or one
/// that would take hours.
[[nodiscard]] Result<trajectory::Interpolator> make_test_path(const TestMotion& motion,
                                                              const ecat_master::AxisConfig& axis);

}  // namespace driveline::runtime
