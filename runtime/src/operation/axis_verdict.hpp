#pragma once

#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "record/recorder.hpp"

namespace driveline::runtime {

/// How a run has left an axis that nobody has complained about so far: one that never was in Operation enabled, or that
/// ended far from where it was sent (ecat_master::position_tolerance()). `period`: of the axis' exchange; `increments`:
/// beside what is in the unit of the axis. Empty: all is well, or it was not there to be judged.
[[nodiscard]] std::string axis_verdict(const ecat_master::AxisConfig& axis, const FollowingError& seen,
                                       std::chrono::nanoseconds period, bool increments);

}  // namespace driveline::runtime
