#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::cli {

/// The findings about this machine as text: the most costly ones first, each with its cost and its remedy, then a line
/// for each item without a problem.
[[nodiscard]] std::string machine_text(const std::vector<rt::RealtimeItem>& items);

/// The findings as a JSON array, in their original order.
[[nodiscard]] nlohmann::json machine_json(const std::vector<rt::RealtimeItem>& items);

}  // namespace driveline::cli
