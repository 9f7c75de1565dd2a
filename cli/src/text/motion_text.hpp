#pragma once

#include <string>

#include "driveline/ecat_master/cyclic/motion.hpp"

namespace driveline::cli {

/// What was wrong with the actual position of `axis`, as a sentence; for the causes kPosition*.
[[nodiscard]] std::string describe_position(const ecat_master::AxisConfig& axis,
                                            const ecat_master::MotionFailure& failure);

}  // namespace driveline::cli
