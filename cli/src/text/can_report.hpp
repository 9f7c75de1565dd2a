#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// State of an adapter for users: "error active".
[[nodiscard]] std::string_view bus_state_text(canopen::BusState state);
/// The CAN bus of a run in its summary; null: the line is one of EtherCAT.
[[nodiscard]] nlohmann::json can_to_json(const runtime::RunReport& report);
/// Same as lines of text; empty: the line is one of EtherCAT.
[[nodiscard]] std::string can_to_text(const runtime::RunReport& report);

}  // namespace driveline::cli
