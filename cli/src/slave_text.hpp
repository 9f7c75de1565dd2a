#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "line_view.hpp"

namespace driveline::cli {

/// One line per slave as the IgH tool prints them: position, alias:position, AL state, + or E (error flag), name.
[[nodiscard]] std::string slave_table(std::span<const SlaveView> slaves);

/// Everything about one slave.
[[nodiscard]] std::string slave_details(const SlaveView& view, const ecat_master::EscInformation& controller);

[[nodiscard]] nlohmann::json slave_json(const SlaveView& view, const ecat_master::EscInformation& controller);

/// "PREOP", or "0x5" for a state that is none.
[[nodiscard]] std::string state_text(wire::AlState state);

}  // namespace driveline::cli
