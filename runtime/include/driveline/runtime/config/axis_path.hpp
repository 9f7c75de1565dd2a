#pragma once

#include <string>
#include "driveline/runtime/error.hpp"

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::runtime {

/// Reads the path of the configured axes, in their order, ready to be followed. Error: a sentence that starts with the
/// file and, where it applies, its line: the file is no valid path, its columns do not fit the axes, or the path leaves
/// the range or the limits of an axis. Without `config.path` all axes rest at 0: a path for Motion::Settings::relative.
///
/// Axes without a unit in the line description get the unit of their column.
[[nodiscard]] Result<trajectory::Interpolator> load_axis_path(LineConfig& config);

}  // namespace driveline::runtime
