#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads a [[slave]]; those above it and [bus] have been read.
[[nodiscard]] SlaveConfig read_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files);

}  // namespace driveline::runtime
