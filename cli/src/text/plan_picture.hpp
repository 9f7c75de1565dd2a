#pragma once

#include <string>

#include "text/move_file.hpp"
#include "text/planned_motion.hpp"

namespace driveline::cli {

/// A motion as SVG: the way in the plane of the two coordinates that go farthest (of the only one over time), the speed
/// along it over time, and the outputs where they change.
[[nodiscard]] std::string picture_of(const MoveFile& file, const PlannedMotion& motion);

}  // namespace driveline::cli
