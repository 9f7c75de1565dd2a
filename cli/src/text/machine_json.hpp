#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/trajectory/machine.hpp"

namespace driveline::cli {

/// The machine in a file of moves: {"type": "delta", "unit": "mm", "base_radius": 200, ...}. The error is a sentence
/// without a full stop.
[[nodiscard]] tl::expected<trajectory::Machine, std::string> parse_machine(const nlohmann::json& machine);
/// The other way.
[[nodiscard]] nlohmann::json to_json(const trajectory::Machine& machine);
/// Where coordinates of moves are: [{"name": "x", "unit": "mm", "setpoint": 12.5}, ...]. `place`: in rad or m; without
/// a setpoint where it is shorter.
[[nodiscard]] nlohmann::json to_json(const std::vector<runtime::events::EventAxis>& coordinates,
                                     const std::vector<double>& place);

}  // namespace driveline::cli
