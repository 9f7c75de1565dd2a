#pragma once

#include <vector>

#include "driveline/ecat_master/configuration/pdo_mapping.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"

namespace driveline::ecat_master {

/// A sync manager of a slave.
struct SyncManagerPlace {
  std::size_t slave = 0;          ///< index in the list of slaves
  std::uint8_t sync_manager = 0;  ///< number of the sync manager
};

/// Reads the PDOs that slaves have assigned to sync managers (1C10h + number) and their mapping, over CoE and all in
/// parallel; the mailboxes of the slaves must be open. One result per place.
///
/// Not every slave answers as the standard says: a list that ends before its number of elements is used as far as it
/// can be read, and a mapping that cannot be read is taken from the slave's description; both are added to `notes`.
/// Errors: SdoAbort for an assignment, or a mapping without description, that the slave does not show; SdoSize,
/// Mailbox*, those of the bus.
[[nodiscard]] std::vector<Result<std::vector<motion::PdoMapping>>> read_assignments(
    MailboxEngine& engine, std::span<const SlaveInfo> slaves, std::span<const SyncManagerPlace> places,
    StartupNotes& notes);

/// The mapping of a PDO in the description; empty: it has no such PDO.
[[nodiscard]] std::optional<std::vector<motion::MappedObject>> described_mapping(const esi::DeviceDescription& device,
                                                                                 std::uint16_t index);

}  // namespace driveline::ecat_master
