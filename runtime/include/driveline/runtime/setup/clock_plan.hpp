#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Makes the plan for the clocks of the slaves on the line, from [dc] and the `dc` tables. The signals of a slave are
/// those of the operation mode in its EEPROM (the named one, else the first with SYNC0), with the changes in the file.
/// On virtual time there is no time of day: `time` is ignored, and the clocks show virtual time. Errors: a mode that
/// the slave does not have, a reference that is not on the line. `config` must outlive the plan, which reads from it
/// the signals of slaves that join later.
[[nodiscard]] Result<ecat_master::dc::ClockPlan> make_clock_plan(const LineConfig& config,
                                                                 std::span<const ecat_master::ConfiguredSlave> slaves,
                                                                 bool virtual_time = false);

}  // namespace driveline::runtime
