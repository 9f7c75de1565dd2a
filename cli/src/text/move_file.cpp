#include "text/move_file.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/path_shaper.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using trajectory::GroupVector;
using trajectory::PathMove;

/// What is wrong with a line; the file and the line are added where it is caught.
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

/// Reads line after line; what a move does not say is as in the move before it.
class MoveReader {
 public:
  MoveFile take() { return std::move(file_); }
  [[nodiscard]] bool has_axes() const { return !file_.axes.empty(); }

  void read_axes(const json& line) {
    refuse_unknown_keys(line, {"axes", "start", "cycle_us"});
    if (!line.contains("axes") || !line["axes"].is_array()) {
      throw BadLine{"the first line describes the axes: {\"axes\": [{\"name\": \"x\", \"unit\": \"mm\", ...}]}"};
    }
    const auto& axes = line["axes"];
    if (axes.empty() || axes.size() > trajectory::kMaxGroupAxes) {
      throw BadLine{fmt::format("a group has 1 to 8 axes, not {}", axes.size())};
    }
    for (const auto& axis : axes) read_axis(axis);
    file_.settings.axes = file_.axes.size();
    if (line.contains("cycle_us")) file_.settings.period_s = number_of(line["cycle_us"], "cycle_us") * 1e-6;
    if (const auto wrong = trajectory::check_settings(file_.settings); !wrong.empty()) throw BadLine{wrong};
    if (line.contains("start")) file_.start = place_of(line["start"], "start", {}, false);
    check_start();
    at_ = file_.start;
  }

  void read_move(const json& line, std::size_t number) {
    PathMove move;
    if (line.contains("feed")) feed_ = first_unit().to_si(number_of(line["feed"], "feed"));
    if (line.contains("tolerance")) tolerance_ = first_unit().to_si(number_of(line["tolerance"], "tolerance"));
    move.feed = feed_;
    move.tolerance = tolerance_;
    if (line.contains("line") || line.contains("line_by")) {
      const bool is_relative = line.contains("line_by");
      refuse_unknown_keys(line, {is_relative ? "line_by" : "line", "feed", "tolerance"});
      move.target =
          is_relative ? place_of(line["line_by"], "line_by", at_, true) : place_of(line["line"], "line", at_, false);
    } else if (line.contains("arc")) {
      read_arc(line, move);
    } else if (line.contains("spline")) {
      read_spline(line, move);
    } else {
      throw BadLine{"a move is one of line, line_by, arc and spline"};
    }
    at_ = move.kind == PathMove::Kind::kSpline ? move.points.back() : move.target;
    file_.moves.push_back({std::move(move), number});
  }

 private:
  [[nodiscard]] const trajectory::PositionUnit& first_unit() const { return *file_.axes.front().unit; }

  /// The shaper knows how far away the first place may be.
  void check_start() const {
    try {
      const trajectory::PathShaper shaper(file_.axes.size(), file_.start);
    } catch (const std::invalid_argument& wrong) {
      throw BadLine{wrong.what()};
    }
  }

  void read_axis(const json& axis) {
    if (!axis.is_object()) throw BadLine{"an axis is an object with name, unit and limits"};
    refuse_unknown_keys(axis, {"name", "unit", "max_velocity", "max_acceleration", "max_jerk"});
    if (!axis.contains("name") || !axis["name"].is_string()) throw BadLine{"an axis needs a name"};
    const auto name = axis["name"].get<std::string>();
    if (!trajectory::check_axis_name(name)) {
      throw BadLine{fmt::format("\"{}\" is no name of an axis: 1 to 31 letters, digits and _-.", name)};
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
    file_.settings.limits[file_.axes.size()] = {limit("max_velocity"), limit("max_acceleration"), limit("max_jerk")};
    file_.axes.push_back({name, unit});
  }

  /// A number per axis; null: where the axis is.
  GroupVector place_of(const json& values, std::string_view what, const GroupVector& at, bool is_relative) const {
    if (!values.is_array() || values.size() != file_.axes.size()) {
      throw BadLine{fmt::format("{} must be an array of {} numbers, one for each axis", what, file_.axes.size())};
    }
    GroupVector place = at;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i].is_null()) continue;
      const double value =
          file_.axes[i].unit->to_si(number_of(values[i], fmt::format("{} of axis {}", what, file_.axes[i].name)));
      place[i] = is_relative ? at[i] + value : value;
    }
    return place;
  }

  std::size_t axis_called(const json& name) const {
    for (std::size_t i = 0; name.is_string() && i < file_.axes.size(); ++i) {
      if (file_.axes[i].name == name.get<std::string>()) return i;
    }
    throw BadLine{fmt::format("there is no axis {}", name.dump())};
  }

  void read_arc(const json& line, PathMove& move) const {
    refuse_unknown_keys(line, {"arc", "center", "via", "clockwise", "plane", "feed", "tolerance"});
    move.target = place_of(line["arc"], "arc", at_, false);
    if (line.contains("via") == line.contains("center")) {
      throw BadLine{"an arc needs either its center or a point via which it goes"};
    }
    if (line.contains("via")) {
      if (line.contains("clockwise") || line.contains("plane")) {
        throw BadLine{"clockwise and plane belong to an arc around a center"};
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
    refuse_unknown_keys(line, {"spline", "feed", "tolerance"});
    if (!line["spline"].is_array() || line["spline"].empty()) {
      throw BadLine{"spline must be an array of at least one point"};
    }
    move.kind = PathMove::Kind::kSpline;
    GroupVector at = at_;
    for (const auto& point : line["spline"])
      move.points.push_back(at = place_of(point, "a point of spline", at, false));
  }

  MoveFile file_;
  GroupVector at_{};
  double feed_ = std::numeric_limits<double>::infinity();
  double tolerance_ = 0.0;
};

json object_of(const std::string& line) {
  auto document = json::parse(line, nullptr, false);
  if (document.is_discarded()) throw BadLine{"this is not JSON"};
  if (!document.is_object()) throw BadLine{"a line must be a JSON object, {...}"};
  return document;
}

}  // namespace

tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name) {
  MoveReader reader;
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
  if (file.axes.empty()) return tl::unexpected(fmt::format("{}: there is no line that describes the axes", name));
  if (file.moves.empty()) return tl::unexpected(fmt::format("{}: there is no move", name));
  return file;
}

}  // namespace driveline::cli
