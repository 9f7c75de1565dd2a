#pragma once

#include "config/toml_reader.hpp"
#include "driveline/cli/line_config.hpp"
#include "text/fault_text.hpp"

namespace driveline::cli {

/// Reads one [[fault]]. Throws ConfigError.
[[nodiscard]] FaultPlan read_fault(TomlReader reader, const FaultPlaces& places);

}  // namespace driveline::cli
