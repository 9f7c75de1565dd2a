#pragma once

#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "record/recorder.hpp"

namespace driveline::runtime {

/// Checks an axis without a fault at the end of a run: a sentence if it was never in Operation enabled, or ended
/// farther from its setpoint than ecat_master::position_tolerance(). `period`: between two exchanges of the axis;
/// `increments`: show drive increments beside the unit of the axis. Empty: no complaint, or the axis was unavailable.
[[nodiscard]] std::string axis_verdict(const ecat_master::AxisConfig& axis, const FollowingError& seen,
                                       std::chrono::nanoseconds period, bool increments);

}  // namespace driveline::runtime
