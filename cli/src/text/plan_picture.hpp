#pragma once

#include <string>

#include "text/move_file.hpp"
#include "text/planned_motion.hpp"

namespace driveline::cli {

/// A motion as SVG: the path in the plane of the two coordinates with the largest range (a single coordinate over
/// time), the speed along it over time, and the changes of the outputs.
[[nodiscard]] std::string picture_of(const MoveFile& file, const PlannedMotion& motion);

}  // namespace driveline::cli
