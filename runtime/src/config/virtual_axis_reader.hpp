#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the [[virtual_axis]] tables into LineConfig::axes, behind those with a drive.
void read_virtual_axes(TomlReader& root, LineConfig& config);

/// Refuses them beside a [path], which moves all axes of a line. Behind that.
void check_virtual_axes(TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
