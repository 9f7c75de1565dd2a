#pragma once

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the position range of an axis, in its unit: the software limits min_position and max_position, or modulo, the
/// length after which positions of an endless axis repeat. Unit and scale of the axis have been read.
void read_axis_range(TomlReader& reader, motion::AxisConfig& axis);

/// Reads only the software limits: both ends, or none.
void read_software_limits(TomlReader& reader, motion::AxisConfig& axis);

/// Checks that each modulo is large enough to show the direction of motion between two exchanges.
void check_moduli(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
