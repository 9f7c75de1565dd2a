#pragma once

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Returns the plan for the master of a CAN line: identities, start-up SDOs of the axes and of the file, PDOs, error
/// control. Nodes have the numbers of their [[slave]]. Precondition: LineConfig::can.
[[nodiscard]] canopen::MasterPlan make_master_plan(const LineConfig& config);

}  // namespace driveline::runtime
