#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "driveline/runtime/groups/group_door.hpp"
#include "failure.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// A group that a path is read for.
struct PathGroup {
  runtime::WayLimits limits;  ///< name, axes, how far they may go, machine and outputs
  std::vector<double> place;  ///< where it stands, or its tool: a coordinate for each axis, rad or m
  double tolerance = 0.0;     ///< at corners behind moves that say none, m or rad
};

/// Reads a file of moves for a group that stands somewhere, and checks all of it: its axes and its machine must be
/// those of the group, its `start`, if it has one, the place of the group; its limits are those of the line. Outputs of
/// the moves are numbered as the group has them. Failure: status 2, with file and line.
[[nodiscard]] Outcome<std::vector<FileMove>> read_group_path(const std::filesystem::path& file, const PathGroup& group);
/// The same for text that is at hand.
[[nodiscard]] Outcome<std::vector<FileMove>> parse_group_path(const std::string& text, const std::string& name,
                                                              const PathGroup& group);

}  // namespace driveline::cli
