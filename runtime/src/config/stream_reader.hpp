#pragma once

#include <optional>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [stream] for a line with these axes; none: streams are off.
[[nodiscard]] std::optional<StreamConfig> read_stream(TomlReader reader, const std::vector<motion::AxisConfig>& axes);

}  // namespace driveline::runtime
