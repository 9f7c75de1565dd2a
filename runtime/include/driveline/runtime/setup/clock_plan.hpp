#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The plan for the clocks of the slaves that have been found, from [dc] and the `dc` tables: each slave's signals are
/// those of the operation mode in its EEPROM (the named one, else the first with SYNC0), changed by what the file says.
/// On virtual time there is no time of the day: the clocks show the virtual one whatever `time` says. Failure: a mode
/// that the slave does not have; a reference that is not there. `config` must outlive the plan: slaves that join later
/// get theirs out of it.
[[nodiscard]] Result<ecat_master::dc::ClockPlan> make_clock_plan(const LineConfig& config,
                                                                 std::span<const ecat_master::ConfiguredSlave> slaves,
                                                                 bool virtual_time = false);

}  // namespace driveline::runtime
