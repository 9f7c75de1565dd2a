#pragma once

#include <tl/expected.hpp>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/configuration/pdo_misfit.hpp"

namespace driveline::ecat_master {

/// Makes the device description of the plan (SlavePlan::esi) that of the slave: sync managers, FMMUs, PDOs, names, DC
/// modes and mailbox are those of the file from now on; identity, serial number and alias stay those that were found.
/// Completes the plan with time limits, watchdogs, start-up commands and PDOs of the file: the plan takes precedence
/// over the file, the file over the EEPROM. Without a description in the plan that of the EEPROM is used (again).
void apply_description(ConfiguredSlave& slave);

/// The description of a device as a master uses it: that of the file, with the identity and EEPROM of the slave.
[[nodiscard]] esi::DeviceDescription merge_description(const esi::DeviceDescription& eeprom,
                                                       const esi::DeviceDescription& file);

/// Start-up commands of a description file (InitCmd) for the transitions to PREOP and SAFEOP (both before SAFEOP, once
/// the mailbox is open) and to OP.
[[nodiscard]] std::vector<StartupSdo> startup_commands(const esi::DeviceDescription& device);

/// Completes PDOs without objects or without sync manager from the description.
void complete_pdos(const esi::DeviceDescription& device, PdoConfiguration& pdos);

/// Whether a device can exchange `pdos` at all: fixed PDOs as they are, mandatory ones there, none that exclude each
/// other, mapping and assignment changed only where the device allows it.
[[nodiscard]] tl::expected<void, PdoMisfit> check_pdos(const esi::DeviceDescription& device,
                                                       const PdoConfiguration& pdos);

/// The SDOs to be written so that the device exchanges `pdos`: the mapping of PDOs that are not fixed, if it can be
/// changed (CoE PdoConfig), and the assignment of every process data sync manager (1C10h + its number), if that can
/// (PdoAssign). Nothing for a device with neither.
[[nodiscard]] std::vector<SdoScript::Step> pdo_script(const PdoConfiguration& pdos,
                                                      const esi::DeviceDescription& device);

}  // namespace driveline::ecat_master
