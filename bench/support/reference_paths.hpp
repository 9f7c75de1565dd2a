#pragma once

#include <string>
#include <vector>

#include "driveline/trajectory/path_move.hpp"

namespace driveline::bench {

/// A path for comparing motions, with the axes' limits.
struct ReferencePath {
  std::string name;
  trajectory::GroupVector start{};
  std::vector<trajectory::PathMove> moves;
};

/// A straight move as fast as the axes can.
[[nodiscard]] trajectory::PathMove line_to(const trajectory::GroupVector& target, double tolerance);

/// Twenty paths of up to three axes: polygons, zigzags, circles, pockets, splines and random lines.
[[nodiscard]] std::vector<ReferencePath> reference_paths();

}  // namespace driveline::bench
