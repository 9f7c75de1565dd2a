#pragma once

#include <tl/expected.hpp>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/configuration/pdo_misfit.hpp"

namespace driveline::ecat_master {

/// Applies the device description of the plan (SlavePlan::esi) to the slave: sync managers, FMMUs, PDOs, names, DC
/// modes and mailbox come from the file; identity, serial number and alias remain as found. Completes the plan with
/// time limits, watchdogs, start-up commands and PDOs of the file: the plan takes precedence over the file, the file
/// over the EEPROM. Without a description in the plan, restores the description of the EEPROM.
void apply_description(ConfiguredSlave& slave);

/// The description that the master uses: that of the file, with the identity and EEPROM of the slave.
[[nodiscard]] esi::DeviceDescription merge_description(const esi::DeviceDescription& eeprom,
                                                       const esi::DeviceDescription& file);

/// Start-up commands (InitCmd) of a description file for the transitions to PREOP and SAFEOP (both written before
/// SAFEOP, once the mailbox is open) and to OP.
[[nodiscard]] std::vector<motion::StartupSdo> startup_commands(const esi::DeviceDescription& device);

/// Completes PDOs that lack objects or a sync manager from the description.
void complete_pdos(const esi::DeviceDescription& device, motion::PdoConfiguration& pdos);

/// Checks whether a device can exchange `pdos`: fixed PDOs unchanged, mandatory PDOs present, no PDOs that exclude each
/// other, mapping and assignment changed only where the device allows it.
[[nodiscard]] tl::expected<void, PdoMisfit> check_pdos(const esi::DeviceDescription& device,
                                                       const motion::PdoConfiguration& pdos);

/// The plans by which the device exchanges `pdos`: the mapping of PDOs that are not fixed, if the device supports it
/// (CoE PdoConfig), and the assignment of every process data sync manager (1C10h + its number), if the device supports
/// it (PdoAssign). Empty for a device that supports neither.
[[nodiscard]] std::vector<AssignmentPlan> plan_assignments(const motion::PdoConfiguration& pdos,
                                                           const esi::DeviceDescription& device);

}  // namespace driveline::ecat_master
