#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/canopen_master/can_master.hpp"

namespace driveline::cli {

/// What the master of a CAN line knows of its nodes and its adapter, as lines of text.
[[nodiscard]] std::string nodes_text(canopen::CanMaster& master);
/// Same as JSON: "nodes" and "adapter".
[[nodiscard]] nlohmann::json nodes_json(canopen::CanMaster& master);

}  // namespace driveline::cli
