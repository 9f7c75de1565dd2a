#pragma once

#include <optional>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/event/axis_events.hpp"

namespace driveline::runtime {

/// What is wrong with the numbers of a request, as far as the configuration of the axis tells; none: nothing.
[[nodiscard]] std::optional<AxisRefusal> check_request(const ecat_master::AxisConfig& axis,
                                                       const ecat_master::AxisRequest& request);

}  // namespace driveline::runtime
