#include "config/axis_group_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/axis_name.hpp"

namespace driveline::runtime {
namespace {

constexpr double kMaxFeed = 1e6;
constexpr double kLeastFeed = 1e-6;
constexpr double kMaxTolerance = 1e3;
constexpr std::size_t kLeastAxes = 2;
constexpr double kMaxLength = 1e9;
/// Largest acceleration (m/s^2) and jerk (m/s^3) of a tool.
constexpr double kMaxOfTool = 1e12;
constexpr std::int64_t kMaxBit = 31;
/// Words of requests: a script could not distinguish a group with such a name.
constexpr std::array<std::string_view, 3> kWords{"all", "wait", "sleep"};

std::string read_name(TomlReader& reader, const LineConfig& config) {
  auto name = reader.text("name");
  std::vector<std::string_view> others;
  for (const auto& group : config.axis_groups) others.push_back(group.name);
  if (const auto checked = trajectory::check_axis_name(name, others); !checked) {
    const bool taken = checked.error().fault == trajectory::AxisNameError::Fault::kTaken;
    reader.fail("name", taken
                            ? fmt::format("\"{}\" is there twice", name)
                            : fmt::format("is \"{}\": 1 to 31 letters a to z and A to Z, digits and _-. are expected, "
                                          "and not \"time\"",
                                          name));
  }
  if (std::any_of(config.axes.begin(), config.axes.end(), [&](const auto& axis) { return axis.name == name; }))
    reader.fail("name", fmt::format("\"{}\" is the name of an [[axis]], another name is expected", name));
  if (std::find(kWords.begin(), kWords.end(), name) != kWords.end())
    reader.fail("name", fmt::format("\"{}\" is a reserved word of requests, another name is expected", name));
  return name;
}

std::size_t find_axis(const TomlReader& reader, const LineConfig& config, std::string_view name) {
  std::vector<std::string_view> known;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (config.axes[i].name == name) return i;
    known.emplace_back(config.axes[i].name);
  }
  const auto meant = closest(name, known);
  reader.fail("axes", fmt::format("there is no [[axis]] named \"{}\"{}", name,
                                  meant.empty() ? "" : fmt::format("; did you mean \"{}\"?", meant)));
}

bool has(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::find(axes.begin(), axes.end(), axis) != axes.end();
}

void check_axis(const TomlReader& reader, const LineConfig& config, std::size_t axis) {
  const auto& name = config.axes[axis].name;
  for (const auto& other : config.axis_groups) {
    if (has(other.axes, axis)) reader.fail("axes", fmt::format("\"{}\" is already in group \"{}\"", name, other.name));
  }
}

std::vector<std::size_t> read_axes(TomlReader& reader, const LineConfig& config) {
  const auto names = reader.texts_or("axes", {});
  if (names.size() < kLeastAxes || names.size() > motion::AxisGroups::kMaxAxes) {
    reader.fail("axes", fmt::format("{} are named, {} to {} names of [[axis]] tables are expected", names.size(),
                                    kLeastAxes, motion::AxisGroups::kMaxAxes));
  }
  std::vector<std::size_t> axes;
  for (const auto& name : names) {
    const auto axis = find_axis(reader, config, name);
    if (has(axes, axis)) reader.fail("axes", fmt::format("has \"{}\" twice", name));
    check_axis(reader, config, axis);
    axes.push_back(axis);
  }
  return axes;
}

std::vector<trajectory::NamedAxis> axes_of(const AxisGroupConfig& group, const LineConfig& config) {
  std::vector<trajectory::NamedAxis> axes;
  for (const auto axis : group.axes)
    axes.push_back({config.axes[axis].name, &motion::position_unit(config.axes[axis])});
  return axes;
}

bool is_choice(std::string_view name) {
  const auto kinds = trajectory::kinematic_kinds();
  return std::any_of(kinds.begin(), kinds.end(), [&](const trajectory::KinematicKind& kind) {
    return std::find(kind.choices.begin(), kind.choices.end(), name) != kind.choices.end();
  });
}

/// Reads the machine; its keys and lengths are those of move files.
std::shared_ptr<const trajectory::Machine> read_machine(TomlReader reader) {
  const auto kind = reader.text("type");
  const auto unit = reader.text("unit");
  std::vector<trajectory::MachineValue> values;
  for (const auto& key : reader.keys()) {
    if (key == "type" || key == "unit") continue;
    if (is_choice(key)) {
      values.push_back({key, reader.boolean_or(key, false) ? 1.0 : 0.0, true});
    } else {
      values.push_back({key, reader.number(key, -kMaxLength, kMaxLength), false});
    }
  }
  auto made = trajectory::Machine::make(kind, unit, std::move(values));
  if (!made) reader.fail(made.error().key, made.error().reason);
  return std::make_shared<const trajectory::Machine>(std::move(*made));
}

trajectory::ToolLimits read_tool(TomlReader reader, const trajectory::PositionUnit& unit) {
  trajectory::ToolLimits tool;
  const auto limit = [&](std::string_view key, double most, double& to) {
    if (reader.has(key)) to = unit.to_si(reader.number(key, unit.from_si(kLeastFeed), unit.from_si(most)));
  };
  limit("max_velocity", kMaxFeed, tool.max_velocity);
  limit("max_acceleration", kMaxOfTool, tool.max_acceleration);
  limit("max_jerk", kMaxOfTool, tool.max_jerk);
  reader.finish();
  return tool;
}

GroupOutputConfig read_output(TomlReader reader, const std::vector<GroupOutputConfig>& others) {
  GroupOutputConfig output;
  output.name = reader.text("name");
  std::vector<std::string_view> taken;
  for (const auto& other : others) taken.emplace_back(other.name);
  if (const auto checked = trajectory::check_axis_name(output.name, taken); !checked) {
    const bool twice = checked.error().fault == trajectory::AxisNameError::Fault::kTaken;
    reader.fail("name", twice ? fmt::format("\"{}\" is there twice", output.name)
                              : fmt::format("is \"{}\": 1 to 31 letters a to z and A to Z, digits and _-. are expected",
                                            output.name));
  }
  output.to = reader.text("to");
  output.to_place = reader.place("to");
  if (reader.has("bit")) output.bit = static_cast<unsigned>(reader.integer("bit", 0, kMaxBit));
  reader.finish();
  return output;
}

/// Refuses the keys that are not available for groups with more than kMaxGroupAxes axes (contours only).
void check_contour(TomlReader& reader, const AxisGroupConfig& group) {
  if (group.axes.size() <= trajectory::kMaxGroupAxes) return;
  for (const std::string_view key : {"kinematics", "tool", "output"}) {
    if (reader.has(key))
      reader.fail(key, fmt::format("is for groups of up to {} axes, this one has {}", trajectory::kMaxGroupAxes,
                                   group.axes.size()));
  }
}

/// Reads the machine of a group, if it has one. Returns the unit of the first coordinate.
const trajectory::PositionUnit& read_kinematics(TomlReader& reader, const LineConfig& config, AxisGroupConfig& group) {
  const auto axes = axes_of(group, config);
  if (!reader.has("kinematics")) return *axes.front().unit;
  group.machine = read_machine(reader.table("kinematics"));
  if (const auto wrong = group.machine->fault_of(axes); !wrong.empty()) reader.fail("axes", wrong);
  return *group.machine->coordinates(axes).front().unit;
}

}  // namespace

AxisGroupConfig read_axis_group(TomlReader reader, const LineConfig& config) {
  AxisGroupConfig group;
  group.name = read_name(reader, config);
  group.axes = read_axes(reader, config);
  check_contour(reader, group);
  const auto& unit = read_kinematics(reader, config, group);
  const auto in_unit = [&](std::string_view key, double lowest, double highest) {
    return unit.to_si(reader.number(key, unit.from_si(lowest), unit.from_si(highest)));
  };
  if (reader.has("max_feed")) group.max_feed = in_unit("max_feed", kLeastFeed, kMaxFeed);
  if (reader.has("tolerance")) group.tolerance = in_unit("tolerance", 0.0, kMaxTolerance);
  if (reader.has("tool")) group.tool = read_tool(reader.table("tool"), unit);
  if (group.machine && !std::isfinite(group.tool.max_velocity))
    reader.fail("kinematics",
                "a machine needs a velocity limit of its tool: tool = { max_velocity = ... } is expected");
  for (auto& output : reader.tables("output")) group.outputs.push_back(read_output(std::move(output), group.outputs));
  if (group.outputs.size() > AxisGroupConfig::kMaxOutputs)
    reader.fail("output",
                fmt::format("{} are there, up to {} are possible", group.outputs.size(), AxisGroupConfig::kMaxOutputs));
  reader.finish();
  return group;
}

void check_axis_groups(const TomlReader& root, const LineConfig& config) {
  if (config.axis_groups.empty()) return;
  if (config.path) {
    root.fail("axis_group", "needs axes that wait for requests: remove [path], which moves all axes");
  }
  if (!config.stream) return;
  for (const auto& group : config.axis_groups) {
    for (const auto axis : group.axes) {
      if (!has(config.stream->axes, axis)) continue;
      root.fail("axis_group",
                fmt::format("\"{}\" has axis \"{}\", which [stream] has, too: its axes must be told, and be "
                            "others",
                            group.name, config.axes[axis].name));
    }
  }
}

}  // namespace driveline::runtime
