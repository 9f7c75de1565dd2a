#pragma once

#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads one [[fault]]. Throws ConfigError.
[[nodiscard]] FaultPlan read_fault(TomlReader reader, const FaultPlaces& places);

}  // namespace driveline::runtime
