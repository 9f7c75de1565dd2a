#include "config/virtual_axis_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "config/axis_range_reader.hpp"
#include "driveline/trajectory/axis_name.hpp"

namespace driveline::runtime {
namespace {

/// Increments per rad or m of a virtual axis, for files that count positions in increments.
constexpr double kVirtualIncrements = 1e6;
/// Limits in rad or m, and their derivatives, as for axes with a drive.
constexpr double kLeastOfVirtual = 1e-6;
constexpr double kMaxVirtualVelocity = 1e6;
constexpr double kMaxVirtualAcceleration = 1e9;
constexpr double kMaxVirtualJerk = 1e12;

const trajectory::PositionUnit* read_virtual_unit(TomlReader& reader) {
  const auto name = reader.text_or("unit", "rad");
  const auto* const unit = trajectory::find_position_unit(name);
  if (unit == nullptr)
    reader.fail("unit", fmt::format("is \"{}\", \"rad\", \"deg\", \"rev\", \"m\", \"mm\" or \"um\" is expected", name));
  return unit;
}

motion::AxisConfig read_virtual_axis(TomlReader reader, const std::vector<motion::AxisConfig>& others) {
  motion::AxisConfig axis;
  axis.slave = motion::AxisConfig::kNoSlave;
  axis.name = reader.text("name");
  std::vector<std::string_view> names;
  for (const auto& other : others) names.push_back(other.name);
  if (const auto checked = trajectory::check_axis_name(axis.name, names); !checked)
    reader.fail("name", describe(checked.error()));
  axis.unit = read_virtual_unit(reader);
  axis.kind = axis.unit->kind;
  axis.increments_per_unit = kVirtualIncrements;
  const auto& unit = *axis.unit;
  const auto limit = [&](std::string_view key, double most) {
    return unit.to_si(reader.number(key, unit.from_si(kLeastOfVirtual), unit.from_si(most)));
  };
  axis.limits = {limit("max_velocity", kMaxVirtualVelocity), limit("max_acceleration", kMaxVirtualAcceleration)};
  if (reader.has("max_jerk")) axis.max_jerk = limit("max_jerk", kMaxVirtualJerk);
  read_software_limits(reader, axis);
  reader.finish();
  return axis;
}

}  // namespace

void read_virtual_axes(TomlReader& root, LineConfig& config) {
  for (auto& reader : root.tables("virtual_axis"))
    config.axes.push_back(read_virtual_axis(std::move(reader), config.axes));
}

void check_virtual_axes(TomlReader& root, const LineConfig& config) {
  const bool some =
      std::any_of(config.axes.begin(), config.axes.end(), [](const auto& one) { return one.is_virtual(); });
  if (some && config.path)
    root.fail("virtual_axis", "needs axes that wait for requests: remove [path], which moves all axes");
}

}  // namespace driveline::runtime
