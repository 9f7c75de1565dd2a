#pragma once

#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads an [[axis_group]]; `config` has the axes and the groups above it.
[[nodiscard]] AxisGroupConfig read_axis_group(TomlReader reader, const LineConfig& config);
/// The groups beside what else may move axes.
void check_axis_groups(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
