#include "stream/stream_bounds.hpp"

#include <cstdint>
#include <limits>

namespace driveline::runtime {

stream::AxisBounds stream_bounds(const motion::AxisConfig& axis) noexcept {
  const double per_unit = axis.increments_per_unit;
  const trajectory::PositionRange all{std::numeric_limits<std::int32_t>::min() / per_unit,
                                      std::numeric_limits<std::int32_t>::max() / per_unit};
  const auto range = axis.software_limits.value_or(all);
  return {range.min, range.max, axis.limits.max_velocity, axis.limits.max_acceleration};
}

}  // namespace driveline::runtime
