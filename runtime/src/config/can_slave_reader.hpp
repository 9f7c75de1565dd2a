#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads a [[slave]] of a CAN line; those above it, [bus] and [master] have been read. Throws ConfigError.
[[nodiscard]] SlaveConfig read_can_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files);

}  // namespace driveline::runtime
