#pragma once

#include <optional>

#include "driveline/runtime/config/command_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// [commands] of a line description; none: it is off. `published`: [telemetry] is not off; `secured`: by DDS
/// Security.
[[nodiscard]] std::optional<CommandConfig> read_commands(TomlReader reader, bool published, bool secured);

}  // namespace driveline::runtime
