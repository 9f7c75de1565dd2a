#pragma once

#include <span>
#include <string>
#include <string_view>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/config/coupling_config.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The verbs for the gear and the cam of an axis: "gear-in", "gear-out", "cam-in", "cam-out", "phase".
[[nodiscard]] std::span<const std::string_view> coupling_verbs();
/// Whether `word` is one of coupling_verbs().
[[nodiscard]] bool is_coupling_verb(std::string_view word);

/// Parses the words after the name of axis `slave`: "gear-in 1/2 at=500mm to=20mm". The first word is a coupling verb.
/// Positions of the master without a unit are in the master's unit. Failure: status 2.
[[nodiscard]] Outcome<runtime::CouplingOrder> parse_coupling_order(std::span<const motion::AxisConfig> axes,
                                                                   const runtime::CouplingPlan& plan, std::size_t slave,
                                                                   std::span<const std::string> words);

}  // namespace driveline::cli
