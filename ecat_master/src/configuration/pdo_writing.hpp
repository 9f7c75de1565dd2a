#pragma once

#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::ecat_master {

/// In PREOP: makes the slaves exchange their planned PDOs. Reads the present assignment and mapping first, and writes
/// only the directions that differ; the slaves in parallel.
///
/// The PDOs of a slave that refuses an optional write, or whose PDOs are not to be written (SlavePlan::needs), are read
/// afterwards: where they differ, they replace the planned ones of the direction in SlavePlan::pdos, and
/// SlavePlan::kept is set for a direction whose assignment is the slave's own. Refusals and replacements are added to
/// `notes`. Errors: NoMailbox, those of SdoTransfer and of read_pdo_configurations().
[[nodiscard]] Result<void> write_planned_pdos(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                              StartupNotes& notes);

}  // namespace driveline::ecat_master
