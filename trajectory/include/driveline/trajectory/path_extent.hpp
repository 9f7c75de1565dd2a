#pragma once

#include <vector>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::trajectory {

/// Range of positions of an axis on a path, rad or m.
struct PathExtent {
  double lowest = 0.0;
  double highest = 0.0;
  double lowest_at_s = 0.0;   ///< time of `lowest` on the path's time axis
  double highest_at_s = 0.0;  ///< time of `highest` on the path's time axis
};

/// Evaluates the whole path at the cycle's period, like the cycle itself, and returns the extent of each axis. For
/// start-up. Leaves the interpolator's cursor at the end. Throws std::invalid_argument unless the period is positive
/// and finite.
[[nodiscard]] std::vector<PathExtent> path_extents(Interpolator& path, double period_s);

/// Whether the extent, shifted by `offset`, lies within the range; an excess of up to 1e-9 of the range counts as
/// rounding. \rtsafe
[[nodiscard]] bool fits(const PathExtent& extent, const PositionRange& range, double offset = 0.0) noexcept;

}  // namespace driveline::trajectory
