#include "config/axis_group_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "driveline/ecat_master/group/axis_groups.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/axis_name.hpp"

namespace driveline::runtime {
namespace {

constexpr double kMostFeed = 1e6;
constexpr double kLeastFeed = 1e-6;
constexpr double kMostTolerance = 1e3;
constexpr std::size_t kLeastAxes = 2;
/// A script could not tell a group of such a name from something else.
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
    reader.fail("name", fmt::format("\"{}\" is the name of an [[axis]], another one is expected", name));
  if (std::find(kWords.begin(), kWords.end(), name) != kWords.end())
    reader.fail("name", fmt::format("\"{}\" is a word of requests, another one is expected", name));
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
    if (has(other.axes, axis)) reader.fail("axes", fmt::format("\"{}\" is in group \"{}\" already", name, other.name));
  }
}

std::vector<std::size_t> read_axes(TomlReader& reader, const LineConfig& config) {
  const auto names = reader.texts_or("axes", {});
  if (names.size() < kLeastAxes || names.size() > ecat_master::AxisGroups::kMostAxes) {
    reader.fail("axes", fmt::format("{} are named, {} to {} names of [[axis]] tables are expected", names.size(),
                                    kLeastAxes, ecat_master::AxisGroups::kMostAxes));
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

}  // namespace

AxisGroupConfig read_axis_group(TomlReader reader, const LineConfig& config) {
  AxisGroupConfig group;
  group.name = read_name(reader, config);
  group.axes = read_axes(reader, config);
  const auto& unit = ecat_master::position_unit(config.axes[group.axes.front()]);
  const auto in_unit = [&](std::string_view key, double lowest, double highest) {
    return unit.to_si(reader.number(key, unit.from_si(lowest), unit.from_si(highest)));
  };
  if (reader.has("max_feed")) group.max_feed = in_unit("max_feed", kLeastFeed, kMostFeed);
  if (reader.has("tolerance")) group.tolerance = in_unit("tolerance", 0.0, kMostTolerance);
  reader.finish();
  return group;
}

void check_axis_groups(const TomlReader& root, const LineConfig& config) {
  if (config.axis_groups.empty()) return;
  if (config.path) {
    root.fail("axis_group", "goes with axes that wait for requests: there must be no [path], which they would follow");
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
