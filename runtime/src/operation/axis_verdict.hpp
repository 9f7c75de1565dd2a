#pragma once

#include <chrono>
#include <optional>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/event.hpp"
#include "record/recorder.hpp"

namespace driveline::runtime {

/// Checks an axis without a fault at the end of a run: events::AxisNeverEnabled, or events::AxisOffItsSetpoint if the
/// axis ended farther from its setpoint than motion::position_tolerance(). `period`: time between two exchanges of
/// the axis. None: no complaint, or the axis was unavailable.
[[nodiscard]] std::optional<EventFacts> axis_verdict(const motion::AxisConfig& axis, const FollowingError& seen,
                                                     std::chrono::nanoseconds period);

}  // namespace driveline::runtime
