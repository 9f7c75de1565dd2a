#pragma once

#include <string>

#include "driveline/ecat_master/cyclic/motion.hpp"

namespace driveline::runtime {

/// A length of `axis` in its unit: "1.25 mm", with `increments` "1.25 mm (1311 increments)". `length`: rad or m.
[[nodiscard]] std::string length_text(const ecat_master::AxisConfig& axis, double length, bool increments);

/// A sentence on what was wrong with the actual position of `axis`, for the causes kPosition*. `increments`: show drive
/// increments beside the unit of the axis.
[[nodiscard]] std::string describe_position(const ecat_master::AxisConfig& axis,
                                            const ecat_master::MotionFailure& failure, bool increments);

}  // namespace driveline::runtime
