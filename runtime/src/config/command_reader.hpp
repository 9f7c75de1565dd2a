#pragma once

#include <optional>

#include "driveline/runtime/config/command_config.hpp"
#include "driveline/runtime/config/telemetry_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [commands] of a line description. Commands arrive through the bridge of [telemetry]. None: commands are off.
[[nodiscard]] std::optional<CommandConfig> read_commands(TomlReader reader, const TelemetryConfig& telemetry);

}  // namespace driveline::runtime
