#pragma once

#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"

namespace driveline::bridge {

/// Checks for settings that Fast DDS would silently ignore or truncate, or refuse without a reason.
[[nodiscard]] tl::expected<void, DdsError> check(const DdsConfig& config);

}  // namespace driveline::bridge
