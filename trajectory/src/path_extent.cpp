#include "driveline/trajectory/path_extent.hpp"

#include <cmath>
#include <stdexcept>

namespace driveline::trajectory {

std::vector<PathExtent> path_extents(Interpolator& path, double period_s) {
  if (!(period_s > 0.0) || !std::isfinite(period_s))
    throw std::invalid_argument("the period must be positive and finite");
  std::vector<AxisSetpoint> now(path.axes().size());
  std::vector<PathExtent> extents;
  // Multiplying instead of accumulating keeps the grid exact; the last sample is the first one after the end.
  for (double sample = 0.0;; sample += 1.0) {
    const double time_s = path.start_s() + sample * period_s;
    path.evaluate(time_s, now);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double position = now[i].position;
      if (i == extents.size()) extents.push_back({position, position, time_s, time_s});
      auto& extent = extents[i];
      if (position < extent.lowest) {
        extent.lowest = position;
        extent.lowest_at_s = time_s;
      }
      if (position > extent.highest) {
        extent.highest = position;
        extent.highest_at_s = time_s;
      }
    }
    if (path.finished(time_s)) return extents;
  }
}

bool fits(const PathExtent& extent, const PositionRange& range, double offset) noexcept {
  constexpr double kRounding = 1e-9;
  const double margin = kRounding * (range.max - range.min);
  return extent.lowest + offset >= range.min - margin && extent.highest + offset <= range.max + margin;
}

}  // namespace driveline::trajectory
