#pragma once

#include <vector>

#include "driveline/esi/device_description.hpp"

/// Mappings for the modes of operation, for the device description only.
namespace driveline::slaves::msd {

/// Returns the operation modes for configuration tools: a mode of operation, with or without SYNC0, and its PDOs.
[[nodiscard]] std::vector<esi::DcOpMode> mode_op_modes();

}  // namespace driveline::slaves::msd
