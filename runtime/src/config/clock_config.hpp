#pragma once

#include <string>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [dc]. `slaves` have been read, because the reference clock is one of them.
[[nodiscard]] ClockConfig read_clocks(TomlReader reader, std::chrono::nanoseconds period,
                                      const std::vector<SlaveConfig>& slaves);

/// Reads the `dc` table of a [[slave]].
[[nodiscard]] SlaveClockConfig read_slave_clock(TomlReader reader);

}  // namespace driveline::runtime
