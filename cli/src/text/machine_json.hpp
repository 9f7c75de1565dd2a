#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/trajectory/machine.hpp"

namespace driveline::cli {

/// Parses the machine of a file of moves: {"type": "delta", "unit": "mm", "base_radius": 200, ...}. The error is a
/// sentence without a full stop.
[[nodiscard]] tl::expected<trajectory::Machine, std::string> parse_machine(const nlohmann::json& machine);
/// Writes a machine in the format of parse_machine().
[[nodiscard]] nlohmann::json to_json(const trajectory::Machine& machine);
/// Positions of coordinates: [{"name": "x", "unit": "mm", "setpoint": 12.5}, ...]. `place`: in rad or m; coordinates
/// beyond its size have no setpoint.
[[nodiscard]] nlohmann::json to_json(const std::vector<runtime::events::EventAxis>& coordinates,
                                     const std::vector<double>& place);

}  // namespace driveline::cli
