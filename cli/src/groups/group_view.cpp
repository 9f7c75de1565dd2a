#include "groups/group_view.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "text/machine_json.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using trajectory::GroupVector;
using trajectory::PathMove;

std::string text(const json& group, std::string_view key) {
  const auto value = group.find(key);
  return value == group.end() || value->get_ref<const std::string&>().empty() ? "-" : value->get<std::string>();
}

std::string names_of(const json& group) {
  std::vector<std::string> names;
  for (const auto& axis : group.at("axes")) names.push_back(axis.at("name").get<std::string>());
  const auto machine =
      group.contains("kinematics") ? group.at("kinematics").at("type").get<std::string>() + ": " : std::string{};
  return fmt::format("{}{}", machine, fmt::join(names, ", "));
}

/// The coordinates of moves: the axes, or the coordinates of the tool.
const json& coordinates_of(const json& group) {
  return group.contains("coordinates") ? group.at("coordinates") : group.at("axes");
}

/// The setpoints as "x 10 mm, y 20 mm".
std::string places_of(const json& coordinates) {
  std::vector<std::string> places;
  for (const auto& axis : coordinates) {
    if (!axis.contains("setpoint")) return "-";
    places.push_back(fmt::format("{} {:.6g} {}", axis.at("name").get<std::string>(), axis.at("setpoint").get<double>(),
                                 axis.at("unit").get<std::string>()));
  }
  return fmt::format("{}", fmt::join(places, ", "));
}

std::string place_of(const json& group) {
  return places_of(coordinates_of(group));
}

/// Why the group is in GroupErrorStop: "axis x: the drive reports a fault".
std::string error_of(const runtime::GroupRequests& group_requests, std::size_t group,
                     const motion::GroupReport& report) {
  auto sentence = runtime::describe(group_requests.event_group(group), group_requests.refusal_of(report));
  const auto colon = sentence.find(": ");
  return colon == std::string::npos ? sentence : sentence.substr(colon + 2);
}

json place_json(const GroupVector& place, std::size_t axes) {
  auto numbers = json::array();
  for (std::size_t i = 0; i < axes; ++i) numbers.push_back(place.at(i));
  return numbers;
}

/// Thrown for a malformed move; parse_move() catches it.
struct BadMove {
  std::string reason;
};

double number_in(const json& value, std::string_view what) {
  if (!value.is_number()) throw BadMove{fmt::format("{} must be a number", what)};
  return value.get<double>();
}

GroupVector place_in(const json& move, const char* key, std::size_t axes) {
  const auto found = move.find(key);
  if (found == move.end() || !found->is_array() || found->size() != axes)
    throw BadMove{fmt::format("{} must be an array of {} numbers", key, axes)};
  GroupVector place{};
  for (std::size_t i = 0; i < axes; ++i) place.at(i) = number_in((*found)[i], key);
  return place;
}

void read_arc(const json& move, std::size_t axes, PathMove& path) {
  path.kind = PathMove::Kind::kArc;
  path.center = place_in(move, "center", axes);
  path.clockwise = move.contains("clockwise") && move["clockwise"] == true;
  const auto plane = move.find("plane");
  if (plane == move.end()) return;
  if (!plane->is_array() || plane->size() != 2 || !(*plane)[0].is_number_unsigned() ||
      !(*plane)[1].is_number_unsigned())
    throw BadMove{"plane must be an array of two numbers of axes"};
  path.first_axis = (*plane)[0].get<std::size_t>();
  path.second_axis = (*plane)[1].get<std::size_t>();
  if (path.first_axis >= axes || path.second_axis >= axes) throw BadMove{"plane names an axis that does not exist"};
}

void read_outputs(const json& outputs, PathMove& path) {
  if (!outputs.is_array()) throw BadMove{"outputs must be an array of changes"};
  for (const auto& output : outputs) {
    if (!output.is_object() || !output.contains("output") || !output["output"].is_number_unsigned() ||
        !output.contains("value"))
      throw BadMove{"a change of an output has its number, output, and a value"};
    trajectory::MoveOutput change;
    change.change.output = output["output"].get<std::uint32_t>();
    change.change.value = number_in(output["value"], "value");
    if (output.contains("at")) change.at = number_in(output["at"], "at");
    path.outputs.push_back(change);
  }
}

PathMove move_in(const json& move, std::size_t axes) {
  if (!move.is_object()) throw BadMove{"a move is an object"};
  PathMove path;
  if (move.contains("points")) {
    path.kind = PathMove::Kind::kSpline;
    if (!move["points"].is_array() || move["points"].empty()) throw BadMove{"points must be an array of positions"};
    for (const auto& point : move["points"]) path.points.push_back(place_in(json{{"points", point}}, "points", axes));
  } else {
    path.target = place_in(move, "to", axes);
    if (move.contains("via")) {
      path.kind = PathMove::Kind::kArcVia;
      path.via = place_in(move, "via", axes);
    } else if (move.contains("center")) {
      read_arc(move, axes, path);
    }
  }
  path.feed = move.contains("feed") ? number_in(move["feed"], "feed") : std::numeric_limits<double>::infinity();
  if (move.contains("tolerance")) path.tolerance = number_in(move["tolerance"], "tolerance");
  if (move.contains("dwell")) path.dwell_s = number_in(move["dwell"], "dwell");
  if (move.contains("outputs")) read_outputs(move["outputs"], path);
  return path;
}

json outputs_json(const std::vector<runtime::GroupOutputLimits>& outputs) {
  auto made = json::array();
  for (const auto& output : outputs)
    made.push_back({{"name", output.name}, {"minimum", output.least}, {"maximum", output.most}});
  return made;
}

runtime::events::EventAxis described(const json& axis, const trajectory::PositionUnit& unit) {
  runtime::events::EventAxis made;
  made.name = axis.at("name").get<std::string>();
  made.unit = unit;
  return made;
}

/// Null: the unit is unknown.
const trajectory::PositionUnit* unit_of(const json& axis) {
  return trajectory::find_position_unit(axis.at("unit").get<std::string>());
}

}  // namespace

json to_json(const runtime::GroupStatus& status, const runtime::AxisGroupConfig& config) {
  auto axes = json::array();
  const auto& described = status.limits.group.axes;
  for (std::size_t i = 0; i < described.size(); ++i) {
    const auto& unit = described[i].unit;
    json axis = {{"name", described[i].name}, {"unit", std::string(unit.name)}};
    if (i < status.setpoint.size()) axis["setpoint"] = unit.from_si(status.setpoint[i]);
    if (const auto& range = status.limits.ranges[i]) {
      axis["min_position"] = unit.from_si(range->min);
      axis["max_position"] = unit.from_si(range->max);
    }
    axes.push_back(std::move(axis));
  }
  const auto& unit = status.limits.group.coordinates.front().unit;
  json group = {{"name", status.limits.group.name}, {"owner", status.owner}, {"axes", std::move(axes)}};
  if (status.limits.machine) {
    group["kinematics"] = to_json(*status.limits.machine);
    group["coordinates"] = to_json(status.limits.group.coordinates, status.place);
  }
  if (!status.limits.outputs.empty()) group["outputs"] = outputs_json(status.limits.outputs);
  group["unit"] = std::string(unit.name);
  group["tolerance"] = unit.from_si(config.tolerance);
  if (!status.report) return group;
  const auto& report = *status.report;
  group["state"] = std::string(to_text(report.state));
  group["override"] = report.override_factor;
  group["speed"] = unit.from_si(report.speed);
  group["length"] = unit.from_si(report.length);
  group["interrupted"] = report.interrupted;
  group["backwards"] = report.backwards;
  return group;
}

Outcome<PathGroup> path_group(const json& group) {
  PathGroup made;
  try {
    made.limits.group.name = group.at("name").get<std::string>();
    for (const auto& axis : group.at("axes")) {
      const auto* unit = unit_of(axis);
      if (unit == nullptr || !axis.contains("setpoint")) return failed("the line is not in operation");
      made.limits.group.axes.push_back(described(axis, *unit));
      std::optional<trajectory::PositionRange> range;
      if (axis.contains("min_position")) {
        range = trajectory::PositionRange{unit->to_si(axis.at("min_position").get<double>()),
                                          unit->to_si(axis.at("max_position").get<double>())};
      }
      made.limits.ranges.push_back(range);
    }
    for (const auto& coordinate : coordinates_of(group)) {
      const auto* unit = unit_of(coordinate);
      if (unit == nullptr || !coordinate.contains("setpoint"))
        return failed(
            "the tool has no position: the joints of the machine are in an impossible combination of positions");
      made.limits.group.coordinates.push_back(described(coordinate, *unit));
      made.place.push_back(unit->to_si(coordinate.at("setpoint").get<double>()));
    }
    if (group.contains("kinematics")) {
      auto machine = parse_machine(group.at("kinematics"));
      if (!machine) return failed(fmt::format("the line reports an unknown machine: {}", machine.error()));
      made.limits.machine = std::make_shared<const trajectory::Machine>(std::move(*machine));
    }
    for (const auto& output : group.value("outputs", json::array())) {
      made.limits.outputs.push_back({output.at("name").get<std::string>(), output.at("minimum").get<double>(),
                                     output.at("maximum").get<double>()});
    }
    made.tolerance = made.limits.group.coordinates.at(0).unit.to_si(group.at("tolerance").get<double>());
  } catch (const std::exception& wrong) {
    return failed(fmt::format("the report of the line about its group is not understood: {}", wrong.what()));
  }
  return made;
}

json groups_json(const runtime::GroupRequests& group_requests) {
  auto rows = json::array();
  for (std::size_t i = 0; i < group_requests.groups().size(); ++i) {
    const auto status = group_requests.status(i);
    auto row = to_json(status, group_requests.groups()[i]);
    const bool fails = status.report && status.report->error != motion::GroupError::kNone;
    if (fails) row["error"] = error_of(group_requests, i, *status.report);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string groups_text(const runtime::GroupRequests& group_requests) {
  std::string lines;
  for (const auto& group : groups_json(group_requests)) {
    const auto owner = text(group, "owner");
    const auto place = group.contains("kinematics") ? fmt::format(" at {}", place_of(group)) : std::string{};
    lines += fmt::format("group {} ({}): {}{}, commanded by {}\n", group.at("name").get<std::string>(), names_of(group),
                         text(group, "state"), place, owner == "-" ? "nobody" : owner);
  }
  return lines;
}

std::string group_line(const json& group) {
  if (!group.contains("state")) return fmt::format("group {}", group.at("name").get<std::string>());
  return fmt::format("group {}: {} at {}{}", group.at("name").get<std::string>(), text(group, "state"), place_of(group),
                     group.at("interrupted").get<bool>() ? ", held" : "");
}

std::string groups_table(const json& groups) {
  std::string table;
  for (const auto& group : groups) {
    const auto unit = group.at("unit").get<std::string>();
    table += fmt::format("group {} ({})\n", group.at("name").get<std::string>(), names_of(group));
    const auto row = [&table](std::string_view name, std::string_view value) {
      table += fmt::format("  {:<14}{}\n", name, value);
    };
    const auto mark = [&group](const char* key) { return group.contains(key) && group.at(key).get<bool>(); };
    row("state",
        text(group, "state") + (mark("interrupted") ? ", held" : "") + (mark("backwards") ? ", backwards" : ""));
    if (group.contains("error")) row("error", text(group, "error"));
    row("place", place_of(group));
    if (group.contains("kinematics")) row("joints", places_of(group.at("axes")));
    if (group.contains("speed")) {
      row("speed", fmt::format("{:.6g} {}/s", group.at("speed").get<double>(), unit));
      row("distance so far", fmt::format("{:.6g} {}", group.at("length").get<double>(), unit));
      row("override", fmt::format("{:.4g} %", 100.0 * group.at("override").get<double>()));
    }
    row("commanded by", text(group, "owner"));
  }
  return table;
}

json to_json(const PathMove& move, std::size_t axes) {
  json made = json::object();
  switch (move.kind) {
    case PathMove::Kind::kSpline: {
      auto points = json::array();
      for (const auto& point : move.points) points.push_back(place_json(point, axes));
      made["points"] = std::move(points);
      break;
    }
    case PathMove::Kind::kArcVia:
      made["via"] = place_json(move.via, axes);
      made["to"] = place_json(move.target, axes);
      break;
    case PathMove::Kind::kArc:
      made["center"] = place_json(move.center, axes);
      made["plane"] = json::array({move.first_axis, move.second_axis});
      if (move.clockwise) made["clockwise"] = true;
      made["to"] = place_json(move.target, axes);
      break;
    case PathMove::Kind::kLine:
      made["to"] = place_json(move.target, axes);
      break;
  }
  if (std::isfinite(move.feed)) made["feed"] = move.feed;
  if (move.tolerance > 0.0) made["tolerance"] = move.tolerance;
  if (move.dwell_s > 0.0) made["dwell"] = move.dwell_s;
  for (const auto& output : move.outputs) {
    json change = {{"output", output.change.output}, {"value", output.change.value}};
    if (std::isfinite(output.at)) change["at"] = output.at;
    made["outputs"].push_back(std::move(change));
  }
  return made;
}

Outcome<PathMove> parse_move(const json& move, std::size_t axes) {
  try {
    return move_in(move, axes);
  } catch (const BadMove& bad) {
    return misused(bad.reason);
  }
}

}  // namespace driveline::cli
