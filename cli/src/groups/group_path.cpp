#include "groups/group_path.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string_view>

#include "driveline/runtime/files/input_file.hpp"

namespace driveline::cli {
namespace {

/// Largest difference between the `start` of a file and the position of the group.
constexpr double kSamePlace = 1e-6;  // m or rad

bool is_blank(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos;
}

std::string names_of(const PathGroup& group) {
  std::vector<std::string_view> names;
  for (const auto& axis : group.limits.group.axes) names.emplace_back(axis.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Why the machine of the file does not match the group; empty: it does.
std::string wrong_machine(const MoveFile& file, const PathGroup& group) {
  const auto& name = group.limits.group.name;
  const auto& own = group.limits.machine;
  if (!own && file.machine)
    return fmt::format("the file has kinematics, but the moves of group {} are moves of its axes", name);
  if (!own) return {};
  if (!file.machine)
    return fmt::format("the file has no kinematics, but the moves of group {} are moves of the tool of a {}", name,
                       own->kind());
  const auto difference = own->difference_to(*file.machine);
  return difference.empty()
             ? difference
             : fmt::format("the machine of the file differs from that of group {}: {}", name, difference);
}

/// Why the outputs of the file do not match the group; empty: they do.
std::string wrong_outputs(const MoveFile& file, const PathGroup& group) {
  std::vector<std::string_view> known;
  for (const auto& output : group.limits.outputs) known.emplace_back(output.name);
  for (const auto& name : file.outputs) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    if (known.empty()) return fmt::format("group {} has no outputs ([[axis_group.output]])", group.limits.group.name);
    return fmt::format("group {} has no output \"{}\"; it has {}", group.limits.group.name, name,
                       fmt::join(known, ", "));
  }
  return {};
}

/// Why the axes of the file do not match the group; empty: they do.
std::string wrong_axes(const MoveFile& file, const PathGroup& group) {
  const auto& axes = group.limits.group.axes;
  bool same = file.axes.size() == axes.size();
  for (std::size_t i = 0; same && i < axes.size(); ++i) same = file.axes[i].name == axes[i].name;
  if (!same)
    return fmt::format("the axes must be those of group {}, in their order: {}", group.limits.group.name,
                       names_of(group));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (file.axes[i].unit->kind == axes[i].unit.kind) continue;
    return fmt::format("the unit of axis {} is {}, but on the line it is in {}", axes[i].name, file.axes[i].unit->name,
                       axes[i].unit.name);
  }
  return {};
}

/// Why the path does not start at the position of the group; empty: it does.
std::string wrong_start(const MoveFile& file, const PathGroup& group) {
  for (std::size_t i = 0; i < file.coordinates.size(); ++i) {
    const auto& unit = *file.coordinates[i].unit;
    const double start = file.start.at(i);
    if (std::abs(start - group.place.at(i)) <= kSamePlace) continue;
    return fmt::format(
        "the path starts at {} {:.6g} {}, but the group is at {:.6g} {}; move the group there, or omit start",
        file.coordinates[i].name, unit.from_si(start), unit.name, unit.from_si(group.place.at(i)), unit.name);
  }
  return {};
}

/// The first mismatch between the head of the file and the group; empty: there is none.
std::string wrong_head(const MoveFile& file, const PathGroup& group) {
  for (const auto& check : {wrong_machine, wrong_axes, wrong_outputs, wrong_start}) {
    if (auto wrong = check(file, group); !wrong.empty()) return wrong;
  }
  return {};
}

/// Number of the line that describes the axes, the first line that is not blank.
std::size_t head_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::size_t number = 1;
  for (; std::getline(lines, line) && is_blank(line); ++number) continue;
  return number;
}

/// Replaces the output numbers of the file by those of the group.
void renumber_outputs(MoveFile& file, const PathGroup& group) {
  const auto& outputs = group.limits.outputs;
  for (auto& next : file.moves) {
    for (auto& output : next.move.outputs) {
      const auto& name = file.outputs.at(output.change.output);
      const auto found =
          std::find_if(outputs.begin(), outputs.end(), [&](const auto& each) { return each.name == name; });
      output.change.output = static_cast<std::uint32_t>(found - outputs.begin());
    }
  }
}

/// The first error in the moves, with file and line; empty: there is none.
std::string wrong_moves(MoveFile& file, const std::string& name, const PathGroup& group) {
  const auto& limits = group.limits;
  auto at = file.start;
  for (const auto& next : file.moves) {
    const auto wrong =
        limits.machine ? runtime::check_outputs(limits, next.move) : runtime::check_group_move(limits, at, next.move);
    if (wrong) return fmt::format("{}:{}: {}", name, next.line, runtime::describe(limits.group, *wrong));
    at = runtime::end_of(next.move);
  }
  if (!limits.machine) return {};
  // Check the whole path, with its corners, against the ranges of the line.
  file.settings = runtime::joint_settings(limits);
  return refusal_of(file, name);
}

}  // namespace

Outcome<std::vector<FileMove>> parse_group_path(const std::string& text, const std::string& name,
                                                const PathGroup& group) {
  if (group.limits.group.axes.size() > trajectory::kMaxGroupAxes) {
    return misused(fmt::format("group {} has {} axes, and files of moves are for up to {}", group.limits.group.name,
                               group.limits.group.axes.size(), trajectory::kMaxGroupAxes));
  }
  MoveDefaults defaults;
  std::copy(group.place.begin(), group.place.end(), defaults.start.emplace().begin());
  defaults.tolerance = group.tolerance;
  auto file = parse_moves(text, name, defaults);
  if (!file) return misused(file.error());
  if (const auto wrong = wrong_head(*file, group); !wrong.empty())
    return misused(fmt::format("{}:{}: {}", name, head_of(text), wrong));
  renumber_outputs(*file, group);
  if (const auto wrong = wrong_moves(*file, name, group); !wrong.empty()) return misused(wrong);
  return std::move(file->moves);
}

Outcome<std::vector<FileMove>> read_group_path(const std::filesystem::path& file, const PathGroup& group) {
  const auto text = runtime::read_input_lines(file);
  if (!text) return tl::unexpected(Failure(text.error()));
  return parse_group_path(*text, file.string(), group);
}

}  // namespace driveline::cli
