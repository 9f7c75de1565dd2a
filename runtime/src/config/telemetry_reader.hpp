#pragma once

#include <chrono>
#include <filesystem>

#include "driveline/runtime/config/telemetry_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [telemetry] of a line description in `folder`; `period` is the cycle time of the line.
[[nodiscard]] TelemetryConfig read_telemetry(TomlReader reader, const std::filesystem::path& folder,
                                             std::chrono::nanoseconds period);

}  // namespace driveline::runtime
