#include "text/move_file.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/path_check.hpp"
#include "driveline/trajectory/path_shaper.hpp"
#include "text/machine_json.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using trajectory::GroupVector;
using trajectory::PathMove;

/// An error in a line; the caller that catches it adds file and line.
struct BadLine {
  std::string reason;
};

using Words = std::vector<std::string_view>;

void refuse_unknown_keys(const json& line, const Words& known) {
  for (const auto& [key, value] : line.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const auto meant = runtime::closest(key, known);
    throw BadLine{fmt::format("there is no key \"{}\" here{}", key,
                              meant.empty() ? std::string{} : fmt::format("; did you mean \"{}\"?", meant))};
  }
}

double number_of(const json& value, std::string_view what) {
  if (!value.is_number()) throw BadLine{fmt::format("{} must be a number", what)};
  return value.get<double>();
}

/// Parses line after line; a move inherits what it leaves out from the previous move.
class MoveReader {
 public:
  /// `folder`: folder of the file.
  MoveReader(std::filesystem::path folder, const MoveDefaults& defaults)
      : folder_(std::move(folder)), start_(defaults.start), tolerance_(defaults.tolerance) {}

  MoveFile take() { return std::move(file_); }
  [[nodiscard]] bool has_axes() const { return !file_.axes.empty(); }

  void read_axes(const json& line) {
    refuse_unknown_keys(line, {"axes", "start", "cycle_us", "kinematics", "tool", "outputs"});
    if (!line.contains("axes") || !line["axes"].is_array()) {
      throw BadLine{"the first line describes the axes: {\"axes\": [{\"name\": \"x\", \"unit\": \"mm\", ...}]}"};
    }
    const auto& axes = line["axes"];
    if (axes.empty() || axes.size() > trajectory::kMaxGroupAxes) {
      throw BadLine{fmt::format("a group has 1 to 8 axes, not {}", axes.size())};
    }
    for (const auto& axis : axes) read_axis(axis);
    file_.settings.axes = file_.axes.size();
    file_.coordinates = file_.axes;
    if (line.contains("kinematics")) read_kinematics(line["kinematics"]);
    if (line.contains("tool")) read_tool(line["tool"]);
    if (line.contains("outputs")) read_output_names(line["outputs"]);
    if (line.contains("cycle_us")) file_.settings.period_s = number_of(line["cycle_us"], "cycle_us") * 1e-6;
    if (const auto wrong = trajectory::check_settings(file_.settings); !wrong.empty()) throw BadLine{wrong};
    if (line.contains("start")) start_ = place_of(line["start"], "start", {}, false);
    file_.start = start_.value_or(GroupVector{});
    check_start(!start_ || line.contains("start"));
    at_ = file_.start;
  }

  void read_move(const json& line, std::size_t number) {
    PathMove move;
    read_events(line, move);
    if (line.contains("feed")) feed_ = first_unit().to_si(number_of(line["feed"], "feed"));
    if (line.contains("tolerance")) tolerance_ = first_unit().to_si(number_of(line["tolerance"], "tolerance"));
    move.feed = feed_;
    move.tolerance = tolerance_;
    if (line.contains("polyline")) return read_polyline(line, move, number);
    if (line.contains("line") || line.contains("line_by")) {
      const bool is_relative = line.contains("line_by");
      refuse_unknown_keys(line, {is_relative ? "line_by" : "line", "feed", "tolerance", "dwell", "outputs"});
      move.target =
          is_relative ? place_of(line["line_by"], "line_by", at_, true) : place_of(line["line"], "line", at_, false);
    } else if (line.contains("arc")) {
      read_arc(line, move);
    } else if (line.contains("spline")) {
      read_spline(line, move);
    } else if (line.contains("dwell") || line.contains("outputs")) {
      refuse_unknown_keys(line, {"feed", "tolerance", "dwell", "outputs"});
      move.target = at_;
    } else {
      throw BadLine{"a move is one of line, line_by, arc, spline and polyline, or has a dwell or outputs"};
    }
    at_ = move.kind == PathMove::Kind::kSpline ? move.points.back() : move.target;
    file_.moves.push_back({std::move(move), number});
  }

 private:
  [[nodiscard]] const trajectory::PositionUnit& first_unit() const { return *file_.coordinates.front().unit; }

  /// Rejects a start that is too far away for the shaper or, with `by_limits`, outside the limits of the file.
  void check_start(bool by_limits) const {
    try {
      const trajectory::PathShaper shaper(file_.axes.size(), file_.start);
    } catch (const std::invalid_argument& wrong) {
      throw BadLine{wrong.what()};
    }
    if (!by_limits) return;
    if (const auto wrong = trajectory::PathCheck(file_.settings, file_.axes).fault_at(file_.start); !wrong.empty()) {
      throw BadLine{"start: " + wrong};
    }
  }

  void read_kinematics(const json& machine) {
    auto made = parse_machine(machine);
    if (!made) throw BadLine{made.error()};
    file_.machine = std::move(*made);
    file_.settings.kinematics = &file_.machine->kinematics();
    if (const auto wrong = file_.machine->fault_of(file_.axes); !wrong.empty()) throw BadLine{wrong};
    file_.coordinates = file_.machine->coordinates(file_.axes);
  }

  void read_tool(const json& tool) {
    if (!tool.is_object()) throw BadLine{"tool is an object with max_velocity, max_acceleration and max_jerk"};
    refuse_unknown_keys(tool, {"max_velocity", "max_acceleration", "max_jerk"});
    const auto limit = [&](const char* key, double& to) {
      if (!tool.contains(key)) return;
      const double value = number_of(tool[key], fmt::format("{} of tool", key));
      if (!(value > 0.0)) throw BadLine{fmt::format("{} of tool is {}; it must be above 0", key, value)};
      to = first_unit().to_si(value);
    };
    limit("max_velocity", file_.settings.tool.max_velocity);
    limit("max_acceleration", file_.settings.tool.max_acceleration);
    limit("max_jerk", file_.settings.tool.max_jerk);
  }

  void read_output_names(const json& names) {
    if (!names.is_array()) throw BadLine{"outputs of the first line is an array of names"};
    for (const auto& name : names) {
      if (!name.is_string() || !trajectory::check_axis_name(name.get<std::string>())) {
        throw BadLine{fmt::format("{} is not a name of an output: 1 to 31 letters, digits and _-.", name.dump())};
      }
      file_.outputs.push_back(name.get<std::string>());
      if (std::count(file_.outputs.begin(), file_.outputs.end(), file_.outputs.back()) > 1) {
        throw BadLine{fmt::format("there are two outputs called \"{}\"", file_.outputs.back())};
      }
    }
  }

  void read_events(const json& line, PathMove& move) const {
    if (line.contains("dwell")) move.dwell_s = number_of(line["dwell"], "dwell");
    if (!line.contains("outputs")) return;
    if (!line["outputs"].is_array()) {
      throw BadLine{"outputs must be an array of changes: [{\"name\": \"gripper\", \"value\": 1}]"};
    }
    for (const auto& output : line["outputs"]) move.outputs.push_back(read_output(output));
  }

  [[nodiscard]] trajectory::MoveOutput read_output(const json& output) const {
    if (!output.is_object()) throw BadLine{"a change of an output is an object with name and value"};
    refuse_unknown_keys(output, {"name", "value", "at"});
    if (!output.contains("name") || !output["name"].is_string() || !output.contains("value")) {
      throw BadLine{"a change of an output needs a name and a value"};
    }
    const auto name = output["name"].get<std::string>();
    const auto found = std::find(file_.outputs.begin(), file_.outputs.end(), name);
    if (found == file_.outputs.end()) {
      const auto meant = runtime::closest(name, Words(file_.outputs.begin(), file_.outputs.end()));
      throw BadLine{fmt::format("the first line names no output \"{}\"{}", name,
                                meant.empty() ? std::string{} : fmt::format("; did you mean \"{}\"?", meant))};
    }
    trajectory::MoveOutput change;
    change.change.output = static_cast<std::uint32_t>(found - file_.outputs.begin());
    const auto& value = output["value"];
    change.change.value =
        value.is_boolean() ? (value.get<bool>() ? 1.0 : 0.0) : number_of(value, fmt::format("value of {}", name));
    if (output.contains("at")) change.at = first_unit().to_si(number_of(output["at"], fmt::format("at of {}", name)));
    return change;
  }

  void read_axis(const json& axis) {
    if (!axis.is_object()) throw BadLine{"an axis is an object with name, unit and limits"};
    refuse_unknown_keys(
        axis, {"name", "unit", "max_velocity", "max_acceleration", "max_jerk", "min_position", "max_position"});
    if (!axis.contains("name") || !axis["name"].is_string()) throw BadLine{"an axis needs a name"};
    const auto name = axis["name"].get<std::string>();
    if (!trajectory::check_axis_name(name)) {
      throw BadLine{fmt::format("\"{}\" is not a name of an axis: 1 to 31 letters, digits and _-.", name)};
    }
    for (const auto& other : file_.axes) {
      if (other.name == name) throw BadLine{fmt::format("there are two axes called \"{}\"", name)};
    }
    const auto* unit = axis.contains("unit") && axis["unit"].is_string()
                           ? trajectory::find_position_unit(axis["unit"].get<std::string>())
                           : nullptr;
    if (unit == nullptr) {
      throw BadLine{
          fmt::format("the unit of axis {} must be \"rad\", \"deg\", \"rev\", \"m\", \"mm\" or \"um\"", name)};
    }
    const auto limit = [&](const char* key) {
      if (!axis.contains(key)) throw BadLine{fmt::format("axis {} needs {}", name, key)};
      const double value = number_of(axis[key], fmt::format("{} of axis {}", key, name));
      if (!(value > 0.0)) throw BadLine{fmt::format("{} of axis {} is {}; it must be above 0", key, name, value)};
      return unit->to_si(value);
    };
    auto& limits = file_.settings.limits[file_.axes.size()];
    limits = {limit("max_velocity"), limit("max_acceleration"), limit("max_jerk")};
    const auto position = [&](const char* key, double& to) {
      if (axis.contains(key)) to = unit->to_si(number_of(axis[key], fmt::format("{} of axis {}", key, name)));
    };
    position("min_position", limits.min_position);
    position("max_position", limits.max_position);
    file_.axes.push_back({name, unit});
  }

  /// Reads one number per axis; null keeps the axis at its position.
  GroupVector place_of(const json& values, std::string_view what, const GroupVector& at, bool is_relative) const {
    if (!values.is_array() || values.size() != file_.coordinates.size()) {
      throw BadLine{fmt::format("{} must be an array of {} numbers, one for each {}", what, file_.coordinates.size(),
                                file_.machine ? "coordinate" : "axis")};
    }
    GroupVector place = at;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i].is_null()) continue;
      const double value = file_.coordinates[i].unit->to_si(
          number_of(values[i], fmt::format("{} of axis {}", what, file_.coordinates[i].name)));
      place[i] = is_relative ? at[i] + value : value;
    }
    return place;
  }

  std::size_t axis_called(const json& name) const {
    for (std::size_t i = 0; name.is_string() && i < file_.coordinates.size(); ++i) {
      if (file_.coordinates[i].name == name.get<std::string>()) return i;
    }
    throw BadLine{fmt::format("there is no axis {}", name.dump())};
  }

  void read_arc(const json& line, PathMove& move) const {
    refuse_unknown_keys(line, {"arc", "center", "via", "clockwise", "plane", "feed", "tolerance", "dwell", "outputs"});
    move.target = place_of(line["arc"], "arc", at_, false);
    if (line.contains("via") == line.contains("center")) {
      throw BadLine{"an arc needs either center or via, a point of the arc"};
    }
    if (line.contains("via")) {
      if (line.contains("clockwise") || line.contains("plane")) {
        throw BadLine{"clockwise and plane need an arc with center"};
      }
      move.kind = PathMove::Kind::kArcVia;
      move.via = place_of(line["via"], "via", at_, false);
      return;
    }
    move.kind = PathMove::Kind::kArc;
    if (line.contains("plane")) {
      const auto& plane = line["plane"];
      if (!plane.is_array() || plane.size() != 2) throw BadLine{"plane must be an array of two names of axes"};
      move.first_axis = axis_called(plane[0]);
      move.second_axis = axis_called(plane[1]);
    }
    move.center = place_of(line["center"], "center", at_, false);
    if (line.contains("clockwise")) {
      if (!line["clockwise"].is_boolean()) throw BadLine{"clockwise must be true or false"};
      move.clockwise = line["clockwise"].get<bool>();
    }
  }

  void read_spline(const json& line, PathMove& move) const {
    refuse_unknown_keys(line, {"spline", "feed", "tolerance", "dwell", "outputs"});
    if (!line["spline"].is_array() || line["spline"].empty()) {
      throw BadLine{"spline must be an array of at least one point"};
    }
    move.kind = PathMove::Kind::kSpline;
    GroupVector at = at_;
    for (const auto& point : line["spline"])
      move.points.push_back(at = place_of(point, "a point of spline", at, false));
  }

  /// Reads straight lines through the points of a CSV file, whose coordinates have the names in that file.
  void read_polyline(const json& line, PathMove& move, std::size_t number) {
    refuse_unknown_keys(line, {"polyline", "feed", "tolerance"});
    if (!line["polyline"].is_string()) throw BadLine{"polyline must be the name of a CSV file"};
    const auto points = trajectory::load_points(folder_ / line["polyline"].get<std::string>());
    if (!points) throw BadLine{points.error().message()};
    std::vector<std::size_t> coordinates;
    for (const auto& axis : points->axes()) {
      coordinates.push_back(axis_called(axis.name));
      if (file_.coordinates[coordinates.back()].unit->kind == axis.kind) continue;
      throw BadLine{fmt::format("{} of {} must be {}", axis.name, line["polyline"].get<std::string>(),
                                axis.kind == trajectory::AxisKind::kRotary ? "a length" : "an angle")};
    }
    for (std::size_t k = 0; k < points->points(); ++k) {
      const auto positions = points->positions(k);
      for (std::size_t i = 0; i < coordinates.size(); ++i) at_[coordinates[i]] = positions[i];
      move.target = at_;
      file_.moves.push_back({move, number, k + 1});
    }
  }

  std::filesystem::path folder_;
  std::optional<GroupVector> start_;
  MoveFile file_;
  GroupVector at_{};
  double feed_ = std::numeric_limits<double>::infinity();
  double tolerance_;
};

json object_of(const std::string& line) {
  auto document = json::parse(line, nullptr, false);
  if (document.is_discarded()) throw BadLine{"this is not JSON"};
  if (!document.is_object()) throw BadLine{"a line must be a JSON object, {...}"};
  return document;
}

}  // namespace

tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name,
                                                const MoveDefaults& defaults) {
  MoveReader reader(std::filesystem::path(name).parent_path(), defaults);
  std::istringstream lines(text);
  std::string line;
  std::size_t number = 0;
  while (std::getline(lines, line)) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      const auto object = object_of(line);
      if (reader.has_axes()) {
        reader.read_move(object, number);
      } else {
        reader.read_axes(object);
      }
    } catch (const BadLine& bad) {
      return tl::unexpected(fmt::format("{}:{}: {}", name, number, bad.reason));
    }
  }
  auto file = reader.take();
  if (file.axes.empty()) return tl::unexpected(fmt::format("{}: the line that describes the axes is missing", name));
  if (file.moves.empty()) return tl::unexpected(fmt::format("{}: there is no move", name));
  return file;
}

std::string refusal_of(const MoveFile& file, const std::string& name) {
  const trajectory::PathCheck check(file.settings, file.axes);
  trajectory::PathShaper shaper(file.settings.axes, file.start, &check);
  std::vector<trajectory::ShapedPiece> pieces;
  for (const auto& [move, line, point] : file.moves) {
    pieces.clear();
    if (const auto added = shaper.add(move, pieces); !added) {
      return fmt::format("{}:{}: {}{}", name, line, point > 0 ? fmt::format("point {}: ", point) : "",
                         added.error().reason);
    }
  }
  return "";
}

}  // namespace driveline::cli
