#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Reads what a [[slave]] is: by `model` of one of the line's families, or of those that a file tells, `esi` or `sii`;
/// and how the master configures it, by `esi`. Throws ConfigError.
void read_slave_device(TomlReader& reader, const LineConfig& config, DeviceFiles& files, SlaveConfig& slave);

}  // namespace driveline::runtime
