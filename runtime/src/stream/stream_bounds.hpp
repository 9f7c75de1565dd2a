#pragma once

#include "driveline/motion/axis/axis.hpp"
#include "driveline/stream/greeting.hpp"

namespace driveline::runtime {

/// Returns the bounds of setpoints of an axis: positions within its software limits, as the drive counts, or without
/// limits the range of 32 bits; and its velocity limit.
[[nodiscard]] stream::AxisBounds stream_bounds(const motion::AxisConfig& axis) noexcept;

}  // namespace driveline::runtime
