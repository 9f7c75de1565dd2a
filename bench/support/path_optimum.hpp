#pragma once

#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_shaper.hpp"

namespace driveline::bench {

/// How fast a path can be gone through at all, found by means that have nothing in common with the planner but the
/// geometry. The least duration lies between the two.
struct PathOptimum {
  /// Duration of a motion that keeps the limits of velocity, acceleration and jerk of every axis wherever it was looked
  /// at (16 places on each of the intervals of the grid): the best that a numeric optimisation has found. Not proven to
  /// be the least.
  double achieved_s = 0.0;
  /// Nothing is faster: the least duration when jerk costs nothing, on a grid of 20 um.
  double bound_s = 0.0;
};

/// Of a path of axes without kinematics, whose tool has no limits of its own. `fineness`: so many times as many places.
[[nodiscard]] PathOptimum path_optimum(const std::vector<trajectory::ShapedPiece>& pieces,
                                       const trajectory::ContourSettings& settings, int fineness = 1);

}  // namespace driveline::bench
