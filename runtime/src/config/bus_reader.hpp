#pragma once

#include "config/device_files.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Longest name of a line or slave in the telemetry records.
inline constexpr std::size_t kMaxNameLength = 31;
/// What is expected of such a name.
inline constexpr std::string_view kNameLengthText = "must have 1 to 31 characters";

/// Reads the name of the line from [line].
void read_line_name(TomlReader& reader, LineConfig& config);

/// Reads how long axes may be without process data from [bus], in cycles or as a time; the cycle time has been read.
void read_max_lost(TomlReader& reader, LineConfig& config);

/// Reads [line] of a line of EtherCAT: name and cycle time.
void read_line(TomlReader reader, LineConfig& config);

/// Reads [bus] of a line of EtherCAT; the cycle time has been read.
void read_bus(TomlReader reader, DeviceFiles& files, LineConfig& config);

/// Reads [realtime]; the cycle time has been read.
void read_realtime(TomlReader reader, LineConfig& config);

}  // namespace driveline::runtime
