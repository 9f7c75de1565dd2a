#pragma once

#include "driveline/cli/line_config.hpp"
#include "fault_text.hpp"
#include "toml_reader.hpp"

namespace driveline::cli {

/// Reads one [[fault]]. Throws ConfigError.
[[nodiscard]] FaultPlan read_fault(TomlReader reader, const FaultPlaces& places);

}  // namespace driveline::cli
