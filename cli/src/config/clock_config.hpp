#pragma once

#include <string>
#include <vector>

#include "config/toml_reader.hpp"
#include "driveline/cli/line_config.hpp"

namespace driveline::cli {

/// Reads [dc]. `slaves` have been read: the reference clock is one of them.
[[nodiscard]] ClockConfig read_clocks(TomlReader reader, std::chrono::nanoseconds period,
                                      const std::vector<SlaveConfig>& slaves);

/// Reads the `dc` table of a [[slave]].
[[nodiscard]] SlaveClockConfig read_slave_clock(TomlReader reader);

}  // namespace driveline::cli
