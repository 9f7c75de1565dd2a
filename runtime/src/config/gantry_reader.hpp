#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// One [[gantry]]; axes, path and stream have been read. Both axes get limits that the pair can keep together.
void read_gantry(TomlReader reader, LineConfig& config);

}  // namespace driveline::runtime
