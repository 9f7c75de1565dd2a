#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// The document of `run --json`; its keys are a contract (docs/command_line.md).
[[nodiscard]] nlohmann::json to_json(const runtime::RunReport& report);

/// The summary of a run for motion engineers, as text.
[[nodiscard]] std::string to_text(const runtime::RunReport& report);

}  // namespace driveline::cli
