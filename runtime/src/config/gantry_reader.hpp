#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads one [[gantry]]; axes, path and stream have been read. Gives both axes limits that the pair can keep together.
void read_gantry(TomlReader reader, LineConfig& config);

}  // namespace driveline::runtime
