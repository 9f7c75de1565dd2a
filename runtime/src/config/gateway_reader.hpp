#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [gateway] for a line with these slaves.
[[nodiscard]] GatewayConfig read_gateway(TomlReader reader, const std::vector<SlaveConfig>& slaves);

}  // namespace driveline::runtime
