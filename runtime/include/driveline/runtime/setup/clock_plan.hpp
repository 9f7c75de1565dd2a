#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The plan for the clocks of the slaves that have been found, from [dc] and the `dc` tables: each slave's signals are
/// those of the operation mode in its EEPROM (the named one, else the first with SYNC0), with the changes that the file
/// makes. On virtual time there is no time of day: `time` is ignored, the clocks show virtual time. Error: a mode that
/// the slave does not have, a reference that is not on the line. `config` must outlive the plan, which reads the
/// signals of slaves that join later from it.
[[nodiscard]] Result<ecat_master::dc::ClockPlan> make_clock_plan(const LineConfig& config,
                                                                 std::span<const ecat_master::ConfiguredSlave> slaves,
                                                                 bool virtual_time = false);

}  // namespace driveline::runtime
