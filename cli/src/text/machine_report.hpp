#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::cli {

/// What was found about this machine, for people: what costs most comes first, each with its price and its remedy, then
/// one line for everything that is fine.
[[nodiscard]] std::string machine_text(const std::vector<rt::RealtimeItem>& items);

/// The same for programs, an array in the order in which it was found.
[[nodiscard]] nlohmann::json machine_json(const std::vector<rt::RealtimeItem>& items);

}  // namespace driveline::cli
