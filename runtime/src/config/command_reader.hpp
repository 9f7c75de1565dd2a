#pragma once

#include <optional>

#include "driveline/runtime/config/command_config.hpp"
#include "driveline/runtime/config/telemetry_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// [commands] of a line description, which has [telemetry], by whose bridge commands come; none: it is off.
[[nodiscard]] std::optional<CommandConfig> read_commands(TomlReader reader, const TelemetryConfig& telemetry);

}  // namespace driveline::runtime
