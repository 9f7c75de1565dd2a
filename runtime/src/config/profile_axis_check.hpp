#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Refuses whatever gives setpoints to an axis whose drive plans its motions: [path], [stream], groups, gantries and
/// couplings. All of them have been read.
void check_profile_axes(TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
