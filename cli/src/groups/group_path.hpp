#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "driveline/runtime/groups/group_requests.hpp"
#include "failure.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// The group that is to follow a path.
struct PathGroup {
  runtime::MoveLimits limits;  ///< name, axes and their ranges, machine and outputs
  std::vector<double> place;   ///< position of the group or its tool: one coordinate per axis, rad or m
  double tolerance = 0.0;      ///< at corners after moves without a tolerance, m or rad
};

/// Reads a file of moves for a group and checks all of it: its axes and its machine must match the group, its `start`,
/// if present, the position of the group; the limits are those of the line. Outputs of the moves are renumbered to
/// those of the group. Failure: status 2, with file and line.
[[nodiscard]] Outcome<std::vector<FileMove>> read_group_path(const std::filesystem::path& file, const PathGroup& group);
/// The same for a text in memory. `name`: the file name in failures.
[[nodiscard]] Outcome<std::vector<FileMove>> parse_group_path(const std::string& text, const std::string& name,
                                                              const PathGroup& group);

}  // namespace driveline::cli
