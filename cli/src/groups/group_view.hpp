#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/runtime/groups/group_door.hpp"
#include "failure.hpp"
#include "groups/group_path.hpp"

namespace driveline::cli {

/// Name, axes with their places, state and owner of a group.
[[nodiscard]] nlohmann::json to_json(const runtime::GroupStatus& status, const runtime::AxisGroupConfig& config);
/// What such a document tells of the group that a path is for. Failure: it is none.
[[nodiscard]] Outcome<PathGroup> path_group(const nlohmann::json& group);
/// Of every group.
[[nodiscard]] nlohmann::json groups_json(const runtime::GroupDoor& door);
/// "group plotter (x, y): GroupStandby, commanded by nobody", a line for each group.
[[nodiscard]] std::string groups_text(const runtime::GroupDoor& door);
/// "group plotter: GroupStandby at x 10 mm, y 20 mm", of a group in that document.
[[nodiscard]] std::string group_line(const nlohmann::json& group);
/// A table of groups in that document.
[[nodiscard]] std::string groups_table(const nlohmann::json& groups);

/// A move as it is told to a running line: in rad and m, places with as many numbers as the group has axes.
[[nodiscard]] nlohmann::json to_json(const trajectory::PathMove& move, std::size_t axes);
/// The move in such a document. Failure (status 2): what is wrong with it.
[[nodiscard]] Outcome<trajectory::PathMove> parse_move(const nlohmann::json& move, std::size_t axes);

}  // namespace driveline::cli
