#include "config/profile_axis_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace driveline::runtime {
namespace {

bool contains(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::find(axes.begin(), axes.end(), axis) != axes.end();
}

/// Returns the table that gives setpoints to the axis; empty: none.
std::string_view table_of_setpoints(const LineConfig& config, std::size_t axis) {
  if (config.path) return "path";
  if (config.stream && contains(config.stream->axes, axis)) return "stream";
  for (const auto& group : config.axis_groups) {
    if (contains(group.axes, axis)) return "axis_group";
  }
  for (const auto& gantry : config.gantries) {
    if (gantry.leader == axis || gantry.follower == axis) return "gantry";
  }
  for (const auto& coupling : config.couplings.couplings) {
    if (coupling.slave == axis || coupling.axis == axis) return "coupling";
  }
  return {};
}

}  // namespace

void check_profile_axes(TomlReader& root, const LineConfig& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const auto& axis = config.axes[i];
    if (!motion::cia402::by_drive(axis.mode)) continue;
    if (const auto table = table_of_setpoints(config, i); !table.empty()) {
      root.fail(table, fmt::format("needs axes that follow setpoints, but the drive of \"{}\" plans its motions itself "
                                   "(mode \"{}\"): it can be moved by requests to it alone",
                                   axis.name, to_text(axis.mode)));
    }
  }
}

}  // namespace driveline::runtime
