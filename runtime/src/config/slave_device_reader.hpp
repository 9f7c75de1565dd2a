#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Reads the device of a [[slave]], by the `model` of a family of the line or from a file, `esi` or `sii`; and the
/// description for its configuration by the master, from `esi`. Throws ConfigError.
void read_slave_device(TomlReader& reader, const LineConfig& config, DeviceFiles& files, SlaveConfig& slave);

/// Reads the device of a [[slave]] on a CAN line, by the `model` of a family; name and node-ID of `slave` have been
/// read. Throws ConfigError.
[[nodiscard]] std::shared_ptr<const SlaveDevice> read_can_device(TomlReader& reader, const LineConfig& config,
                                                                 DeviceFiles& files, const SlaveConfig& slave);

}  // namespace driveline::runtime
