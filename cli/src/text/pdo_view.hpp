#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "line/line_view.hpp"

namespace driveline::cli {

/// An object in a PDO; index 0 is a gap.
struct PdoEntryView {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bits = 0;
  std::string name;  ///< empty: unknown
};

struct PdoView {
  std::uint16_t index = 0;
  std::string name;
  std::vector<PdoEntryView> entries;
};

/// A sync manager of a slave and the PDOs assigned to it.
struct SyncManagerView {
  std::size_t number = 0;
  esi::SiiSyncManager registers;
  bool outputs = false;  ///< master to slave: RxPDOs
  std::vector<PdoView> pdos;
};

/// Sync managers and their PDOs according to the EEPROM.
[[nodiscard]] std::vector<SyncManagerView> pdos_from_sii(const esi::SiiImage& sii);

/// Sync managers and their PDOs according to the present assignment and mapping of the slave, read over CoE; names come
/// from the EEPROM as far as it has them. A sync manager whose assignment the slave does not show has the PDOs of the
/// EEPROM, which is reported on stderr. The slave must be in PREOP or above.
[[nodiscard]] Outcome<std::vector<SyncManagerView>> pdos_from_coe(LineView& line, std::size_t position,
                                                                  ecat_master::MailboxClient& mailbox,
                                                                  const esi::SiiImage& sii);

/// The source of the PDOs of a slave.
enum class PdoSource : std::uint8_t { kSii, kCoe };

/// Sync managers and PDOs of a slave.
struct SlavePdos {
  SlaveView slave;
  PdoSource source = PdoSource::kSii;
  std::vector<SyncManagerView> sync_managers;
};

/// Opens the bus and reads the PDOs of the selected slaves: over CoE (LineView::open_mailboxes() with `force`) if a
/// slave has CoE and `only_sii` does not forbid it; else from the EEPROM.
[[nodiscard]] Outcome<std::vector<SlavePdos>> read_pdos(const runtime::BusOptions& bus, const SlaveSelection& selection,
                                                        bool only_sii, bool force);

/// Three indented levels: sync manager, PDO, entry.
[[nodiscard]] std::string to_text(std::span<const SyncManagerView> sync_managers);
[[nodiscard]] nlohmann::json to_json(const SlavePdos& slave);

/// C++ declarations of the slave's PDOs for a SlavePlan of the library.
[[nodiscard]] std::string cpp_declaration(const SlavePdos& slave);

}  // namespace driveline::cli
