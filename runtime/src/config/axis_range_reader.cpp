#include "config/axis_range_reader.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

namespace driveline::runtime {
namespace {

constexpr double kFarthest = 1e6;  // rad or m

/// Reads a position; returns rad or m.
double read_position(TomlReader& reader, std::string_view key, const trajectory::PositionUnit& unit) {
  return unit.to_si(reader.number(key, unit.from_si(-kFarthest), unit.from_si(kFarthest)));
}

void read_modulo(TomlReader& reader, motion::AxisConfig& axis) {
  constexpr double kLeast = 1e-6;  // rad or m
  constexpr double kRoundingIncrements = 1e-3;
  if (!reader.has("modulo")) return;
  if (axis.software_limits)
    reader.fail("modulo", "is for axes without end positions, but min_position and max_position are set");
  if (!reader.has("increments_per_revolution")) {
    reader.fail("modulo",
                "needs increments_per_revolution: the modulo is written to the drive before its increments are read");
  }
  const auto& unit = motion::position_unit(axis);
  const double modulo = unit.to_si(reader.number("modulo", unit.from_si(kLeast), unit.from_si(kFarthest)));
  const double increments = modulo * axis.increments_per_unit;
  const double whole = std::round(increments);
  if (whole < 2.0 || whole > std::numeric_limits<std::int32_t>::max()) {
    reader.fail("modulo", fmt::format("is {:.6g} increments of the drive, 2 to {} are expected", increments,
                                      std::numeric_limits<std::int32_t>::max()));
  }
  if (std::abs(increments - whole) > kRoundingIncrements) {
    reader.fail("modulo", fmt::format("is {:.3f} increments of the drive, a whole number is expected: positions would "
                                      "drift with every turn",
                                      increments));
  }
  axis.modulo = modulo;
  axis.range_min = 0;
  axis.range_max = static_cast<std::int32_t>(whole) - 1;
}

}  // namespace

void read_software_limits(TomlReader& reader, motion::AxisConfig& axis) {
  const bool lowest = reader.has("min_position");
  const bool highest = reader.has("max_position");
  if (!lowest && !highest) return;
  if (!lowest) reader.fail("max_position", "is set without min_position: both are expected");
  if (!highest) reader.fail("min_position", "is set without max_position: both are expected");
  const auto& unit = motion::position_unit(axis);
  const trajectory::PositionRange range{read_position(reader, "min_position", unit),
                                        read_position(reader, "max_position", unit)};
  if (!(range.min < range.max)) {
    reader.fail("max_position", fmt::format("is {:.6g} {}, more than the {:.6g} {} of min_position is expected",
                                            unit.from_si(range.max), unit.name, unit.from_si(range.min), unit.name));
  }
  axis.software_limits = range;
}

void read_axis_range(TomlReader& reader, motion::AxisConfig& axis) {
  read_software_limits(reader, axis);
  read_modulo(reader, axis);
}

void check_moduli(const TomlReader& root, const LineConfig& config) {
  constexpr double kShare = 0.25;  // share of the modulo beyond which the direction of a step is ambiguous
  for (const auto& axis : config.axes) {
    if (axis.range_min >= axis.range_max) continue;
    const double modulo = (axis.range_max - axis.range_min + 1.0) / axis.increments_per_unit;
    const std::chrono::duration<double> exchange = config.period * exchange_divider(config, config.slaves[axis.slave]);
    const double way = axis.limits.max_velocity * exchange.count();
    if (way < kShare * modulo) continue;
    const auto& unit = motion::position_unit(axis);
    root.fail("axis", fmt::format("\"{}\" moves {:.6g} {} between two exchanges at its max_velocity, and less "
                                  "than a quarter of its modulo of {:.6g} {} is expected",
                                  axis.name, unit.from_si(way), unit.name, unit.from_si(modulo), unit.name));
  }
}

}  // namespace driveline::runtime
