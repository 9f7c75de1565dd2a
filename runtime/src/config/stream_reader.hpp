#pragma once

#include <optional>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [stream] for a line with these axes; none: streams are off.
[[nodiscard]] std::optional<StreamConfig> read_stream(TomlReader reader,
                                                      const std::vector<ecat_master::AxisConfig>& axes);

}  // namespace driveline::runtime
