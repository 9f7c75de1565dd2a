#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/observer.hpp"

namespace driveline::runtime {

/// Reports problems of the slaves that do not depend on a description as progress.
void tell_problems(const ecat_master::Master& master, Observer& observer);

/// Master::configure() by the description, or for the slaves as found when `config` is null. Error: the first reason,
/// with the slaves' diagnosis; differences between line and description are reported as progress.
[[nodiscard]] Result<void> configure_line(ecat_master::Master& master, const LineConfig* config, Observer& observer);

}  // namespace driveline::runtime
