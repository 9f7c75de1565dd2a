#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// The document of `run --json`; keys are a contract (docs/command_line.md). `telemetry`: none, it was off.
[[nodiscard]] nlohmann::json to_json(const runtime::RunReport& report,
                                     std::optional<bridge::PublishCounters> telemetry = std::nullopt);

/// The summary a motion engineer wants to read, as text.
[[nodiscard]] std::string to_text(const runtime::RunReport& report,
                                  std::optional<bridge::PublishCounters> telemetry = std::nullopt);

}  // namespace driveline::cli
