#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>

#include "driveline/trajectory/machine.hpp"

namespace driveline::cli {

/// The machine in a file of moves: {"type": "delta", "unit": "mm", "base_radius": 200, ...}. The error is a sentence
/// without a full stop.
[[nodiscard]] tl::expected<trajectory::Machine, std::string> parse_machine(const nlohmann::json& machine);
/// The other way.
[[nodiscard]] nlohmann::json to_json(const trajectory::Machine& machine);

}  // namespace driveline::cli
