#include "stream/stream_bounds.hpp"

#include <cstdint>
#include <limits>

namespace driveline::runtime {

stream::AxisBounds stream_bounds(const ecat_master::AxisConfig& axis) noexcept {
  const double per_unit = axis.increments_per_unit;
  return {std::numeric_limits<std::int32_t>::min() / per_unit, std::numeric_limits<std::int32_t>::max() / per_unit,
          axis.limits.max_velocity, axis.limits.max_acceleration};
}

}  // namespace driveline::runtime
