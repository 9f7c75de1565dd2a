#pragma once

#include <filesystem>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads pitch error and backlash of an axis: `compensation`, a table in a file in `directory`, and `backlash`. The
/// rest of the axis has been read; its limits are reduced to what is left for its motions.
void read_compensation(TomlReader& reader, const std::filesystem::path& directory, motion::AxisConfig& axis);

/// Checks that an axis that is compensated only after homing can be homed.
void check_compensations(const TomlReader& root, const LineConfig& config);

}  // namespace driveline::runtime
