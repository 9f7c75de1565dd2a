#pragma once

#include <span>
#include <string>
#include <string_view>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/config/coupling_config.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// What can be asked about gear and cam of an axis: "gear-in", "gear-out", "cam-in", "cam-out", "phase".
[[nodiscard]] std::span<const std::string_view> coupling_verbs();
/// One of them.
[[nodiscard]] bool is_coupling_verb(std::string_view word);

/// What the words behind the name of the axis number `slave` ask for: "gear-in 1/2 at=500mm to=20mm". The first word is
/// a coupling verb. Places of the master without a unit are in that of the master. Failure: status 2.
[[nodiscard]] Outcome<runtime::CouplingOrder> parse_coupling_order(std::span<const ecat_master::AxisConfig> axes,
                                                                   const runtime::CouplingPlan& plan, std::size_t slave,
                                                                   std::span<const std::string> words);

}  // namespace driveline::cli
