#pragma once

#include <string>
#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"

namespace driveline::bridge {

/// Looks for what Fast DDS would silently ignore, cut or fail on without a reason.
/// @return a sentence that names the value.
[[nodiscard]] tl::expected<void, std::string> check(const DdsConfig& config);

}  // namespace driveline::bridge
