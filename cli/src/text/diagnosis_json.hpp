#pragma once

#include <nlohmann/json_fwd.hpp>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"

namespace driveline::cli {

/// The document of `diag --json` (docs/command_line.md). Keys about the cycle exist only while it runs.
[[nodiscard]] nlohmann::json to_json(const ecat_master::LineDiagnosis& diagnosis);

}  // namespace driveline::cli
