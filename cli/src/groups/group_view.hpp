#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/runtime/groups/group_requests.hpp"
#include "failure.hpp"
#include "groups/group_path.hpp"

namespace driveline::cli {

/// Name, axes with their positions, state and owner of a group.
[[nodiscard]] nlohmann::json to_json(const runtime::GroupStatus& status, const runtime::AxisGroupConfig& config);
/// Reads limits, position and tolerance of the group from such a document. Failure: the line is not in operation, or
/// the document is incomplete.
[[nodiscard]] Outcome<PathGroup> path_group(const nlohmann::json& group);
/// The documents of all groups.
[[nodiscard]] nlohmann::json groups_json(const runtime::GroupRequests& group_requests);
/// "group plotter (x, y): GroupStandby, commanded by nobody", one line per group.
[[nodiscard]] std::string groups_text(const runtime::GroupRequests& group_requests);
/// "group plotter: GroupStandby at x 10 mm, y 20 mm" for a group of that document.
[[nodiscard]] std::string group_line(const nlohmann::json& group);
/// A table of the groups in that document.
[[nodiscard]] std::string groups_table(const nlohmann::json& groups);

/// A move as it is sent to a running line: in rad and m, positions with as many numbers as the group has axes.
[[nodiscard]] nlohmann::json to_json(const trajectory::PathMove& move, std::size_t axes);
/// Parses such a document. Failure (status 2): what is wrong with the move.
[[nodiscard]] Outcome<trajectory::PathMove> parse_move(const nlohmann::json& move, std::size_t axes);

}  // namespace driveline::cli
