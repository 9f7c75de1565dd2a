#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the [[virtual_axis]] tables into LineConfig::axes, after the axes with a drive.
void read_virtual_axes(TomlReader& root, LineConfig& config);

/// Refuses virtual axes together with a [path], which moves all axes of a line. Call after read_virtual_axes().
void check_virtual_axes(TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
