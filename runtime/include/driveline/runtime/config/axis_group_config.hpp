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

/// An [[axis_group.output]]: an output that moves of the group change at positions along their path.
struct GroupOutputConfig {
  std::string name;               ///< name in moves, unique within the group
  std::string to;                 ///< output among the process data, "slave.object"
  std::optional<unsigned> bit{};  ///< bit of the output; none: the whole output
  std::string to_place;  ///< "file:line: [axis_group 1.output 1] to", for errors that appear only on the running line
};

/// An [[axis_group]] of a line description: axes that follow a path together on request.
struct AxisGroupConfig {
  /// The most outputs of a group.
  static constexpr std::size_t kMaxOutputs = 32;

  std::string name;               ///< unique among all groups and axes
  std::vector<std::size_t> axes;  ///< numbers of the [[axis]] tables, in the order of the coordinates
  /// Machine whose joints are the axes, in their order; null: moves are given in axis positions.
  std::shared_ptr<const trajectory::Machine> machine{};
  trajectory::ToolLimits tool{};  ///< limits of the tool point on the path
  /// Highest feed along the path, and default feed of moves: m/s, or rad/s if the first coordinate is an angle.
  /// Infinite: as fast as the axes permit.
  double max_feed = std::numeric_limits<double>::infinity();
  double tolerance = 0.0;                    ///< default corner tolerance of moves, m or rad
  std::vector<GroupOutputConfig> outputs{};  ///< moves name them by their index here
};

}  // namespace driveline::runtime
