#pragma once

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/ecat_master/configuration/process_variables.hpp"

namespace driveline::runtime {

/// Returns the process data of a CAN line by name. Nodes do not tell the names of their objects: those of CiA 402 have
/// the names of the standard, all have their addresses.
[[nodiscard]] ecat_master::ProcessVariables can_variables(const canopen::MasterPlan& plan,
                                                          const canopen::PdoImage& image);

}  // namespace driveline::runtime
