#pragma once

#include <optional>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// Checks the numbers of a request against configuration and state of the axis; none: nothing is wrong.
[[nodiscard]] std::optional<AxisRefusal> check_request(const motion::AxisConfig& axis, const motion::AxisReport& report,
                                                       const motion::AxisRequest& request);

/// Returns the software limits of the axis as its requests count positions; none: the axis has none.
[[nodiscard]] std::optional<trajectory::PositionRange> range_of_requests(const motion::AxisConfig& axis,
                                                                         const motion::AxisReport& report);

}  // namespace driveline::runtime
