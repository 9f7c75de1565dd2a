#include "config/axis_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::cli {
namespace {

using trajectory::Interpolator;
using trajectory::Path;

Interpolator make_interpolator(const Path& path, PathConfig::Interpolation kind) {
  switch (kind) {
    case PathConfig::Interpolation::kLinear:
      return Interpolator::linear(path);
    case PathConfig::Interpolation::kNaturalSpline:
      return Interpolator::natural_spline(path);
    case PathConfig::Interpolation::kClampedSpline:
      break;
  }
  return Interpolator::clamped_spline(path);
}

/// Column of the path for each axis. Error: a reason.
tl::expected<std::vector<std::size_t>, std::string> columns_of(const Path& path, const LineConfig& config) {
  std::vector<std::size_t> columns;
  const auto names = trajectory::axis_names(path.axes());
  for (const auto& axis : config.axes) {
    const auto found = trajectory::find_axis_name(axis.name, names);
    if (!found) {
      return tl::unexpected(
          fmt::format("there is no column for axis \"{}\"{}", axis.name, trajectory::axis_name_hint(axis.name, names)));
    }
    const auto kind = path.axes()[*found].kind;
    if (kind != axis.kind) {
      return tl::unexpected(fmt::format("column \"{}\" is in {} but the axis is {}", axis.name,
                                        unit_or_si(path.axes()[*found].unit, kind).name,
                                        axis.linear() ? "linear" : "rotary (feed_mm_per_revolution makes it linear)"));
    }
    columns.push_back(*found);
  }
  std::vector<std::string_view> known;
  for (const auto& axis : config.axes) known.push_back(axis.name);
  for (const auto& name : names) {
    if (!trajectory::find_axis_name(name, known)) {
      return tl::unexpected(fmt::format("there is no [[axis]] for column \"{}\"", name));
    }
  }
  return columns;
}

/// The path with its axes in the order of the configuration. Error: a reason.
tl::expected<Path, std::string> arrange(const Path& path, const LineConfig& config) {
  const auto columns = columns_of(path, config);
  if (!columns) return tl::unexpected(columns.error());
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < columns->size(); ++i) {
    auto axis = path.axes()[(*columns)[i]];
    if (config.axes[i].unit != nullptr) axis.unit = config.axes[i].unit;
    if (auto added = builder.add_axis(std::move(axis)); !added) return tl::unexpected(added.error().message());
  }
  std::vector<double> positions(columns->size());
  for (std::size_t point = 0; point < path.points(); ++point) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] = path.positions(point)[(*columns)[i]];
      // Position setpoints are 32-bit increments on the wire.
      if (std::abs(positions[i] * config.axes[i].increments_per_unit) > std::numeric_limits<std::int32_t>::max()) {
        return tl::unexpected(fmt::format("axis \"{}\" leaves the 32-bit range of its increments at {} s",
                                          config.axes[i].name, path.times_s()[point]));
      }
    }
    if (auto added = builder.add_point(path.times_s()[point], positions); !added) {
      return tl::unexpected(added.error().message());
    }
  }
  auto arranged = builder.build();
  if (!arranged) return tl::unexpected(arranged.error().message());
  return std::move(*arranged);
}

/// All axes at rest at 0.
tl::expected<Path, std::string> standstill(const LineConfig& config) {
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (auto added = builder.add_axis({config.axes[i].name, config.axes[i].kind}); !added) {
      return tl::unexpected(added.error().message());
    }
  }
  const std::vector<double> zero(config.axes.size());
  for (const double time_s : {0.0, std::chrono::duration<double>(config.period).count()}) {
    if (auto added = builder.add_point(time_s, zero); !added) return tl::unexpected(added.error().message());
  }
  auto path = builder.build();
  if (!path) return tl::unexpected(path.error().message());
  return std::move(*path);
}

std::vector<trajectory::AxisLimits> limits_of(const LineConfig& config) {
  std::vector<trajectory::AxisLimits> limits;
  for (const auto& axis : config.axes) {
    limits.push_back(axis.limits);
    // Corners of a linear path have no finite acceleration; the drives' own interpolation rounds them.
    if (config.path->interpolation == PathConfig::Interpolation::kLinear) {
      limits.back().max_acceleration = std::numeric_limits<double>::infinity();
    }
  }
  return limits;
}

}  // namespace

tl::expected<Interpolator, std::string> load_axis_path(LineConfig& config) {
  if (!config.path) {
    const auto still = standstill(config);
    if (!still) return tl::unexpected(still.error());
    return Interpolator::linear(*still);
  }
  const auto& file = config.path->file;
  auto wrong = [&file](const std::string& reason) {
    return tl::unexpected(fmt::format("{}: {}", file.string(), reason));
  };
  const auto loaded = trajectory::load_path(file);
  if (!loaded) return tl::unexpected(loaded.error().message());
  const auto path = arrange(*loaded, config);
  if (!path) return wrong(path.error());
  auto interpolator = make_interpolator(*path, config.path->interpolation);
  const auto period_s = std::chrono::duration<double>(config.period).count();
  if (auto checked = trajectory::check_limits(interpolator, limits_of(config), period_s); !checked) {
    return wrong(checked.error().message());
  }
  for (std::size_t i = 0; i < config.axes.size(); ++i) config.axes[i].unit = interpolator.axes()[i].unit;
  return interpolator;
}

}  // namespace driveline::cli
