#include "config/compensation_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "driveline/motion/axis/axis_compensation.hpp"

namespace driveline::runtime {
namespace {

/// Default and highest share of the limits of the axis that the take-up of backlash uses.
constexpr double kTakeUpShare = 0.1;
constexpr double kMaxTakeUp = 0.5;
/// Least share of the acceleration that must be left for motions.
constexpr double kLeastLeft = 0.5;

std::optional<trajectory::CorrectionTable> read_correction(TomlReader& reader, const std::filesystem::path& directory,
                                                           const motion::AxisConfig& axis) {
  if (!reader.has("compensation")) return std::nullopt;
  auto table = trajectory::load_correction_table(directory / reader.text("compensation"));
  if (!table) reader.fail("compensation", table.error().message());
  if (table->kind != axis.kind) {
    reader.fail("compensation", fmt::format("{} is in {}, but the axis is {}", table->file, table->unit->name,
                                            axis.linear() ? "linear" : "rotary"));
  }
  return std::move(*table);
}

double read_backlash(TomlReader& reader, const motion::AxisConfig& axis) {
  constexpr double kMaxBacklash = 1.0;  // rad or m
  const auto& unit = motion::position_unit(axis);
  return unit.to_si(reader.number_or("backlash", 0.0, 0.0, unit.from_si(kMaxBacklash)));
}

/// Reads a limit of the backlash take-up: at most the share of `limit` that leaves enough for motions.
double read_take_up(TomlReader& reader, std::string_view key, const motion::AxisConfig& axis, double limit) {
  constexpr double kLeast = 1e-9;
  const auto& unit = motion::position_unit(axis);
  return unit.to_si(
      reader.number_or(key, unit.from_si(kTakeUpShare * limit), kLeast, unit.from_si(kMaxTakeUp * limit)));
}

}  // namespace

void read_compensation(TomlReader& reader, const std::filesystem::path& directory, motion::AxisConfig& axis) {
  const bool wanted = reader.has("compensation") || reader.has("backlash");
  if (!wanted) {
    for (const std::string_view key : {"backlash_velocity", "backlash_acceleration", "compensate"}) {
      if (reader.has(key)) reader.fail(key, "has no effect without compensation or backlash");
    }
    return;
  }
  const auto table = read_correction(reader, directory, axis);
  auto correction = trajectory::PositionCorrection::make(table, read_backlash(reader, axis), axis.modulo);
  if (!correction) reader.fail("compensation", correction.error().message());
  motion::CompensationSettings settings{std::move(*correction)};
  settings.take_up_velocity = read_take_up(reader, "backlash_velocity", axis, axis.limits.max_velocity);
  settings.take_up_acceleration = read_take_up(reader, "backlash_acceleration", axis, axis.limits.max_acceleration);
  settings.when_homed = reader.choice_or("compensate", 0, {"always", "homed"}) == 1;
  const auto left = motion::limits_of_motion(axis.limits, settings);
  const double least = kLeastLeft * (axis.limits.max_acceleration - settings.take_up_acceleration);
  if (!(left.max_acceleration >= least)) {
    const auto& unit = motion::position_unit(axis);
    reader.fail("compensation", fmt::format("is so curved that at max_velocity it needs {:.6g} of the {:.6g} {}/s^2 of "
                                            "max_acceleration: a lower max_velocity or a smoother table is expected",
                                            unit.from_si(axis.limits.max_acceleration - left.max_acceleration),
                                            unit.from_si(axis.limits.max_acceleration), unit.name));
  }
  axis.limits = left;
  axis.compensation = std::make_shared<const motion::CompensationSettings>(std::move(settings));
}

void check_compensations(const TomlReader& root, const LineConfig& config) {
  const auto waits = std::find_if(config.axes.begin(), config.axes.end(),
                                  [](const auto& axis) { return axis.compensation && axis.compensation->when_homed; });
  if (!config.path || waits == config.axes.end()) return;
  root.fail("axis",
            fmt::format("\"{}\" is compensated only after homing, and axes of a [path] are not homed: compensate = "
                        "\"always\" is expected",
                        waits->name));
}

}  // namespace driveline::runtime
