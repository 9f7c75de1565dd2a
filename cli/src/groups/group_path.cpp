#include "groups/group_path.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "driveline/runtime/files/input_file.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

/// Between the `start` of a file and where the group stands.
constexpr double kSamePlace = 1e-6;  // m or rad

bool is_blank(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos;
}

/// The text as the file has it, but that the path begins where the group stands, and that its first move has the
/// tolerance of the group if it says none. Lines that are wrong stay as they are: who reads the moves tells about them.
std::string completed(const std::string& text, const PathGroup& group) {
  std::istringstream lines(text);
  std::string out;
  int seen = 0;
  for (std::string line; std::getline(lines, line); out += line + "\n") {
    if (is_blank(line) || ++seen > 2) continue;
    auto object = json::parse(line, nullptr, false);
    if (!object.is_object()) continue;
    const auto& axes = group.limits.group.axes;
    if (seen == 1) {
      auto start = json::array();
      for (std::size_t i = 0; i < axes.size(); ++i) start.push_back(axes[i].unit.from_si(group.place.at(i)));
      if (!object.contains("start")) object["start"] = std::move(start);
    } else if (!object.contains("tolerance")) {
      object["tolerance"] = axes.front().unit.from_si(group.tolerance);
    }
    line = object.dump();
  }
  return out;
}

std::string names_of(const PathGroup& group) {
  std::vector<std::string_view> names;
  for (const auto& axis : group.limits.group.axes) names.emplace_back(axis.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What is wrong with the axes of a file; empty: nothing.
std::string wrong_axes(const MoveFile& file, const PathGroup& group) {
  if (file.kinematics) return "groups of a line have no kinematics: their axes are the coordinates of the moves";
  if (!file.outputs.empty()) return "groups of a line change no outputs";
  const auto& axes = group.limits.group.axes;
  bool same = file.axes.size() == axes.size();
  for (std::size_t i = 0; same && i < axes.size(); ++i) same = file.axes[i].name == axes[i].name;
  if (!same)
    return fmt::format("the axes must be those of group {}, in their order: {}", group.limits.group.name,
                       names_of(group));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (file.axes[i].unit->kind != axes[i].unit.kind) {
      return fmt::format("the unit of axis {} is {}, and on the line it is in {}", axes[i].name,
                         file.axes[i].unit->name, axes[i].unit.name);
    }
    if (std::abs(file.start.at(i) - group.place.at(i)) > kSamePlace) {
      const auto& unit = *file.axes[i].unit;
      return fmt::format(
          "the path starts at {} {:.6g} {}, and the group stands at {:.6g} {}; move it there, or leave "
          "start out",
          axes[i].name, unit.from_si(file.start.at(i)), unit.name, unit.from_si(group.place.at(i)), unit.name);
    }
  }
  return {};
}

/// The line that describes the axes.
struct Head {
  std::size_t number = 1;
  std::string text;
};

Head head_of(const std::string& text) {
  std::istringstream lines(text);
  Head head;
  for (; std::getline(lines, head.text) && is_blank(head.text); ++head.number) continue;
  return head;
}

/// Places of a tool, told to axes, would lead anywhere.
bool is_of_tool(const Head& head) {
  const auto object = json::parse(head.text, nullptr, false);
  return object.is_object() && object.contains("kinematics");
}

}  // namespace

Outcome<std::vector<FileMove>> parse_group_path(const std::string& text, const std::string& name,
                                                const PathGroup& group) {
  if (group.limits.group.axes.size() > trajectory::kMaxGroupAxes) {
    return misused(fmt::format("group {} has {} axes, and files of moves are for up to {}", group.limits.group.name,
                               group.limits.group.axes.size(), trajectory::kMaxGroupAxes));
  }
  const auto head = head_of(text);
  if (is_of_tool(head)) {
    return misused(fmt::format("{}:{}: kinematics are for plan: the moves of group {} are those of its axes", name,
                               head.number, group.limits.group.name));
  }
  auto file = parse_moves(completed(text, group), name);
  if (!file) return misused(file.error());
  if (const auto wrong = wrong_axes(*file, group); !wrong.empty())
    return misused(fmt::format("{}:{}: {}", name, head.number, wrong));
  auto at = file->start;
  for (const auto& next : file->moves) {
    if (const auto wrong = runtime::check_way(group.limits, at, next.move))
      return misused(fmt::format("{}:{}: {}", name, next.line, runtime::describe(group.limits.group, *wrong)));
    if (!next.move.outputs.empty())
      return misused(
          fmt::format("{}:{}: outputs are for plan: a group of a running line changes none", name, next.line));
    at = runtime::end_of(next.move);
  }
  return std::move(file->moves);
}

Outcome<std::vector<FileMove>> read_group_path(const std::filesystem::path& file, const PathGroup& group) {
  const auto text = runtime::read_input_file(file);
  if (!text) return tl::unexpected(Failure(text.error()));
  return parse_group_path(*text, file.string(), group);
}

}  // namespace driveline::cli
