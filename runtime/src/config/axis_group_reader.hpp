#pragma once

#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads an [[axis_group]]; `config` contains the axes and the preceding groups.
[[nodiscard]] AxisGroupConfig read_axis_group(TomlReader reader, const LineConfig& config);
/// Checks the groups against other tables that move axes.
void check_axis_groups(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
