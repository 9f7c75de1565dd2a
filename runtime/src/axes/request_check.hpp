#pragma once

#include <optional>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// Checks the numbers of a request against configuration and state of the axis; none: nothing is wrong.
[[nodiscard]] std::optional<AxisRefusal> check_request(const ecat_master::AxisConfig& axis,
                                                       const ecat_master::AxisReport& report,
                                                       const ecat_master::AxisRequest& request);

/// Returns the software limits of the axis as its requests count positions; none: the axis has none.
[[nodiscard]] std::optional<trajectory::PositionRange> range_of_requests(const ecat_master::AxisConfig& axis,
                                                                         const ecat_master::AxisReport& report);

}  // namespace driveline::runtime
