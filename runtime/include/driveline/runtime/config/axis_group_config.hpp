#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace driveline::runtime {

/// An [[axis_group]] of a line description: axes that go along a path together when they are asked to.
struct AxisGroupConfig {
  std::string name;               ///< unlike the name of any other group and any axis
  std::vector<std::size_t> axes;  ///< numbers of the [[axis]] tables, in the order of the coordinates
  /// Highest speed along the path, and that of moves that say none: m/s, or rad/s where the first axis is rotary.
  /// Infinite: as fast as the axes can.
  double max_feed = std::numeric_limits<double>::infinity();
  double tolerance = 0.0;  ///< at corners behind moves that say none, m or rad
};

}  // namespace driveline::runtime
