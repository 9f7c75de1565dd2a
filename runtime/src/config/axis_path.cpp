#include "driveline/runtime/config/axis_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/path_extent.hpp"

namespace driveline::runtime {
namespace {

using trajectory::Interpolator;
using trajectory::Path;

/// Returns the column of the path for each axis. Error: a reason.
Result<std::vector<std::size_t>> columns_of(const Path& path, const LineConfig& config) {
  std::vector<std::size_t> columns;
  const auto names = trajectory::axis_names(path.axes());
  for (const auto& axis : config.axes) {
    const auto found = trajectory::find_axis_name(axis.name, names);
    if (!found) {
      return fail(ErrorKind::kSetting, fmt::format("there is no column for axis \"{}\"{}", axis.name,
                                                   trajectory::axis_name_hint(axis.name, names)));
    }
    const auto kind = path.axes()[*found].kind;
    if (kind != axis.kind) {
      return fail(ErrorKind::kSetting,
                  fmt::format("column \"{}\" is in {} but the axis is {}", axis.name,
                              unit_or_si(path.axes()[*found].unit, kind).name,
                              axis.linear() ? "linear" : "rotary (feed_mm_per_revolution makes it linear)"));
    }
    columns.push_back(*found);
  }
  std::vector<std::string_view> known;
  for (const auto& axis : config.axes) known.push_back(axis.name);
  for (const auto& name : names) {
    if (!trajectory::find_axis_name(name, known)) {
      return fail(ErrorKind::kSetting, fmt::format("there is no [[axis]] for column \"{}\"", name));
    }
  }
  return columns;
}

/// Returns the path with its axes in the order of the configuration. Error: a reason.
Result<Path> arrange(const Path& path, const LineConfig& config) {
  const auto columns = columns_of(path, config);
  if (!columns) return tl::unexpected(columns.error());
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < columns->size(); ++i) {
    auto axis = path.axes()[(*columns)[i]];
    if (config.axes[i].unit != nullptr) axis.unit = config.axes[i].unit;
    if (auto added = builder.add_axis(std::move(axis)); !added)
      return fail(ErrorKind::kSetting, added.error().message());
  }
  const auto arranged_row = [&columns](std::span<const double> row) {
    std::vector<double> values;
    for (const std::size_t column : *columns) values.push_back(row.empty() ? 0.0 : row[column]);
    return values;
  };
  for (std::size_t point = 0; point < path.points(); ++point) {
    const auto positions = arranged_row(path.positions(point));
    for (std::size_t i = 0; i < positions.size(); ++i) {
      // Position setpoints are 32-bit increments on the wire.
      if (std::abs(positions[i] * config.axes[i].increments_per_unit) > std::numeric_limits<std::int32_t>::max()) {
        return fail(ErrorKind::kSetting, fmt::format("axis \"{}\" leaves the 32-bit range of its increments at {} s",
                                                     config.axes[i].name, path.times_s()[point]));
      }
    }
    const auto velocities = arranged_row(path.velocities(point));
    const auto accelerations = arranged_row(path.accelerations(point));
    if (auto added = builder.add_point({path.times_s()[point], positions, velocities, accelerations}); !added) {
      return fail(ErrorKind::kSetting, added.error().message());
    }
  }
  auto arranged = builder.build();
  if (!arranged) return fail(ErrorKind::kSetting, arranged.error().message());
  return std::move(*arranged);
}

/// Returns a path on which all axes rest at 0.
Result<Path> standstill(const LineConfig& config) {
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (auto added = builder.add_axis({config.axes[i].name, config.axes[i].kind}); !added) {
      return fail(ErrorKind::kSetting, added.error().message());
    }
  }
  const std::vector<double> zero(config.axes.size());
  for (const double time_s : {0.0, std::chrono::duration<double>(config.period).count()}) {
    if (auto added = builder.add_point(time_s, zero); !added) return fail(ErrorKind::kSetting, added.error().message());
  }
  auto path = builder.build();
  if (!path) return fail(ErrorKind::kSetting, path.error().message());
  return std::move(*path);
}

std::vector<trajectory::AxisLimits> limits_of(const LineConfig& config) {
  std::vector<trajectory::AxisLimits> limits;
  for (const auto& axis : config.axes) {
    limits.push_back(axis.limits);
    // Corners of a linear path have no finite acceleration; the drives' own interpolation rounds them.
    if (config.path->interpolation == trajectory::InterpolationMethod::kLinear) {
      limits.back().max_acceleration = std::numeric_limits<double>::infinity();
    }
  }
  return limits;
}

/// Checks the path against the software limits. A relative path is checked later, when its start is known.
Result<void> check_software_limits(Interpolator& path, const LineConfig& config) {
  const bool limited = std::any_of(config.axes.begin(), config.axes.end(),
                                   [](const auto& axis) { return axis.software_limits.has_value(); });
  if (!limited || config.path->relative) return {};
  const auto extents = trajectory::path_extents(path, std::chrono::duration<double>(config.period).count());
  for (std::size_t i = 0; i < extents.size(); ++i) {
    const auto& range = config.axes[i].software_limits;
    if (!range || trajectory::fits(extents[i], *range)) continue;
    const bool low = extents[i].lowest < range->min;
    const auto& unit = trajectory::unit_or_si(path.axes()[i].unit, path.axes()[i].kind);
    return fail(
        ErrorKind::kSetting,
        fmt::format("axis \"{}\" would go to {:.6g} {} at {:.6g} s; its {} is {:.6g} {}", config.axes[i].name,
                    unit.from_si(low ? extents[i].lowest : extents[i].highest), unit.name,
                    low ? extents[i].lowest_at_s : extents[i].highest_at_s, low ? "min_position" : "max_position",
                    unit.from_si(low ? range->min : range->max), unit.name));
  }
  return {};
}

}  // namespace

Result<Interpolator> load_axis_path(LineConfig& config) {
  if (!config.path) {
    const auto still = standstill(config);
    if (!still) return tl::unexpected(still.error());
    return Interpolator::linear(*still);
  }
  const auto& file = config.path->file;
  const auto loaded = trajectory::load_path(file);
  if (!loaded) {
    return tl::unexpected(Error{ErrorKind::kFile, {}, loaded.error().message(), file, loaded.error().line});
  }
  const auto path = arrange(*loaded, config);
  if (!path) return fail_file(file, path.error().reason);
  auto interpolator = Interpolator::make(*path, config.path->interpolation);
  const auto period_s = std::chrono::duration<double>(config.period).count();
  if (auto checked = trajectory::check_limits(interpolator, limits_of(config), period_s); !checked) {
    return fail_file(file, checked.error().message());
  }
  if (auto checked = check_software_limits(interpolator, config); !checked)
    return fail_file(file, checked.error().reason);
  for (std::size_t i = 0; i < config.axes.size(); ++i) config.axes[i].unit = interpolator.axes()[i].unit;
  return interpolator;
}

}  // namespace driveline::runtime
