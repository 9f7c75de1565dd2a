#pragma once

#include <span>
#include <string>

#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/line/wiring.hpp"

namespace driveline::runtime {

/// Reads [wiring]: who is connected to whom, how long the cables are. `slaves` are the names by position; the wiring
/// that comes out leads the frame past them in this order. Throws ConfigError.
[[nodiscard]] slaves::Wiring read_wiring(TomlReader reader, std::span<const std::string> slaves);

}  // namespace driveline::runtime
