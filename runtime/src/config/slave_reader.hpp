#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the name of a [[slave]], which none of `others` has. Throws ConfigError.
[[nodiscard]] std::string read_slave_name(TomlReader& reader, const std::vector<SlaveConfig>& others);

/// Reads a [[slave]] of a line of EtherCAT; those above it and [bus] have been read. Throws ConfigError.
[[nodiscard]] SlaveConfig read_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files);

}  // namespace driveline::runtime
