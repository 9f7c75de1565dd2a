#pragma once

#include "driveline/ecat_master/configuration/pdo_mapping.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"

namespace driveline::ecat_master {

/// The PDOs that the EEPROM assigns to sync managers, with their mapping.
[[nodiscard]] motion::PdoConfiguration pdo_configuration_from_sii(const esi::DeviceDescription& device);

/// Reads the current assignment and mapping of every process data sync manager, of which a slave may have several per
/// direction: over CoE (1C10h + sync manager, and the mapping objects), else from the EEPROM; all slaves in parallel.
/// The slaves must be in PREOP or above, their mailboxes open in `engine`.
///
/// A sync manager whose assignment the slave aborts, with whatever code, has the PDOs that the description assigns to
/// it; the others keep what was read. This, lists that end early, and mappings of the description are added to `notes`.
///
/// One result per slave. Errors: SdoAbort for a mapping that neither the slave nor its description shows; SdoSize,
/// Mailbox*, those of the bus. Not real-time safe.
[[nodiscard]] std::vector<Result<motion::PdoConfiguration>> read_pdo_configurations(MailboxEngine& engine,
                                                                                    std::span<const SlaveInfo> slaves,
                                                                                    StartupNotes& notes);

/// A PDO of a slave.
struct PdoPlace {
  std::size_t slave = 0;    ///< index in the list of slaves
  std::uint16_t index = 0;  ///< mapping object, 1600h-17FFh or 1A00h-1BFFh
};

/// Reads the current mapping of PDOs, assigned or not: over CoE, or from the EEPROM of a slave without CoE (empty when
/// it does not contain the PDO), and of a slave that aborts the transfer, which is added to `notes`. All in parallel;
/// one result per place. Conditions and errors as for read_pdo_configurations().
[[nodiscard]] std::vector<Result<std::vector<motion::MappedObject>>> read_mappings(MailboxEngine& engine,
                                                                                   std::span<const SlaveInfo> slaves,
                                                                                   std::span<const PdoPlace> places,
                                                                                   StartupNotes& notes);

}  // namespace driveline::ecat_master
