#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [line], [bus] and [master] of a description with [bus] type = "can" into LineConfig::can and what both buses
/// have. Throws ConfigError.
void read_can_line(TomlReader& root, LineConfig& config);

/// Gives the master the highest node-ID that no slave has, if the file gives it none; the slaves have been read. Throws
/// ConfigError.
void choose_master_node(const TomlReader& root, LineConfig& config);

/// Reads the [[fault]] of a CAN line; the slaves have been read. Throws ConfigError.
void read_can_faults(TomlReader& root, LineConfig& config);

}  // namespace driveline::runtime
