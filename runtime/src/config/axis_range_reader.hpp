#pragma once

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Where an axis may be, in its unit: min_position and max_position, its software limits, or modulo, after which
/// positions of an endless axis begin anew. Unit and scale of the axis have been read.
void read_axis_range(TomlReader& reader, ecat_master::AxisConfig& axis);

/// The software limits alone: both of their ends, or none.
void read_software_limits(TomlReader& reader, ecat_master::AxisConfig& axis);

/// A modulo must be so large that it shows between two exchanges which way its axis has gone.
void check_moduli(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
