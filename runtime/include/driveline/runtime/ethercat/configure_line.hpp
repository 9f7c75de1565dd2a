#pragma once

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/observer.hpp"

namespace driveline::runtime {

/// Reports, as progress, problems of the slaves that do not depend on a description.
void tell_problems(const ecat_master::Master& master, Observer& observer);

/// Returns where an operation datum is planned that an error is about, as in StartupIdn::place; empty: the error is
/// about another one, or about something else.
[[nodiscard]] std::string startup_idn_place(const ecat_master::Error& error,
                                            std::span<const ecat_master::ConfiguredSlave> slaves);

/// Runs Master::configure() by the description, or for the slaves as found if `config` is null, and reports
/// Master::startup_notes() as notices. Error: the first reason, with the diagnosis of the slaves; differences between
/// line and description are reported as progress.
[[nodiscard]] Result<void> configure_line(ecat_master::Master& master, const LineConfig* config, Observer& observer);

}  // namespace driveline::runtime
