#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/observer.hpp"

namespace driveline::runtime {

/// What is wrong with the slaves that were found, whatever a description says: told as progress.
void tell_problems(const ecat_master::Master& master, Observer& observer);

/// Master::configure() by the description, or with whatever is there when `config` is null. Error: the first reason,
/// with what the slaves say of it; how the line differs from its description is told as progress.
[[nodiscard]] Result<void> configure_line(ecat_master::Master& master, const LineConfig* config, Observer& observer);

}  // namespace driveline::runtime
