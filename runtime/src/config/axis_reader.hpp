#pragma once

#include <filesystem>
#include <optional>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads an [[axis]]; the slaves and the axes above it have been read. `directory`: where its files are; `mode`: mode
/// of all axes instead of their own.
[[nodiscard]] motion::AxisConfig read_axis(TomlReader reader, const std::filesystem::path& directory,
                                           const LineConfig& config, std::optional<motion::cia402::Mode> mode);

/// Sets the default gain of the velocity loop over the bus: 100/s times the inertia, less if exchanges are rare. The
/// groups of the process data have been read.
void complete_velocity_gains(LineConfig& config);

}  // namespace driveline::runtime
