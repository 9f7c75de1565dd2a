#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/machine.hpp"

namespace driveline::runtime {

/// An [[axis_group.output]]: what moves of the group change at places of their path.
struct GroupOutputConfig {
  std::string name;               ///< as moves call it, unlike the others of the group
  std::string to;                 ///< an output among the process data, "slave.object"
  std::optional<unsigned> bit{};  ///< of it; none: all of it
  std::string to_place;           ///< "file:line: [axis_group 1.output 1] to", for errors that show only with the line
};

/// An [[axis_group]] of a line description: axes that go along a path together when they are asked to.
struct AxisGroupConfig {
  /// The most outputs of a group.
  static constexpr std::size_t kMostOutputs = 32;

  std::string name;               ///< unlike the name of any other group and any axis
  std::vector<std::size_t> axes;  ///< numbers of the [[axis]] tables, in the order of the coordinates
  /// Of which the axes are the joints, in its order; null: moves are in the positions of the axes.
  std::shared_ptr<const trajectory::Machine> machine{};
  trajectory::ToolLimits tool{};  ///< of the point on the path
  /// Highest speed along the path, and that of moves that say none: m/s, or rad/s where the first coordinate is an
  /// angle.
  /// Infinite: as fast as the axes can.
  double max_feed = std::numeric_limits<double>::infinity();
  double tolerance = 0.0;                    ///< at corners behind moves that say none, m or rad
  std::vector<GroupOutputConfig> outputs{};  ///< moves name them by their places here
};

}  // namespace driveline::runtime
