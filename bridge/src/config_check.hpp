#pragma once

#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"

namespace driveline::bridge {

/// Looks for what Fast DDS would silently ignore, cut or fail on without a reason.
[[nodiscard]] tl::expected<void, DdsError> check(const DdsConfig& config);

}  // namespace driveline::bridge
