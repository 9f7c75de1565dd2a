#pragma once

#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_shaper.hpp"

namespace driveline::bench {

/// Bounds of the minimum duration of a path, found by methods that share only the geometry with the planner. The
/// minimum is between the two.
struct PathOptimum {
  /// Duration of a motion that keeps the limits of velocity, acceleration and jerk of every axis at all checked points
  /// (16 on each interval of the grid): the best that numeric optimisation has found. Not proven to be minimal.
  double achieved_s = 0.0;
  /// Lower bound: the minimum duration without a jerk limit, on a grid of 20 um.
  double bound_s = 0.0;
};

/// For a path of axes without kinematics, whose tool has no limits. `fineness`: factor for the number of intervals.
[[nodiscard]] PathOptimum path_optimum(const std::vector<trajectory::ShapedPiece>& pieces,
                                       const trajectory::ContourSettings& settings, int fineness = 1);

}  // namespace driveline::bench
