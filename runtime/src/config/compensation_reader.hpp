#pragma once

#include <filesystem>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Pitch error and backlash of an axis: compensation, a table in a file beside the line description, and backlash. The
/// rest of the axis has been read; its limits become those that are left for its motions.
void read_compensation(TomlReader& reader, const std::filesystem::path& directory, ecat_master::AxisConfig& axis);

/// An axis that is compensated from its homing on must be one that is homed.
void check_compensations(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
