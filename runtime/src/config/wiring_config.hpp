#pragma once

#include <span>
#include <string>

#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/line/wiring.hpp"

namespace driveline::runtime {

/// Reads [wiring]: connections and cable lengths. `slaves` are the names by position; in the resulting wiring the frame
/// passes the slaves in this order. Throws ConfigError.
[[nodiscard]] slaves::Wiring read_wiring(TomlReader reader, std::span<const std::string> slaves);

}  // namespace driveline::runtime
