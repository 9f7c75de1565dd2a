#pragma once

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/stream/greeting.hpp"

namespace driveline::runtime {

/// What setpoints of an axis may be: positions within its software limits, as the drive counts, without them those that
/// its 32 bits can say, and its velocity limit.
[[nodiscard]] stream::AxisBounds stream_bounds(const ecat_master::AxisConfig& axis) noexcept;

}  // namespace driveline::runtime
