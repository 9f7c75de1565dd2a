#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/ecat_master/coe/sdo_transfer.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/motion/cia301/startup_sdo.hpp"

namespace driveline::ecat_master {

/// Values to be written to objects of a slave, in order.
struct SdoScript {
  std::uint16_t position = 0;  ///< position of the slave on the line
  /// A value and its destination.
  struct Step {
    SdoAddress at;                                           ///< object and entry
    std::vector<std::byte> data;                             ///< value to be written
    motion::WriteNeed need = motion::WriteNeed::kMandatory;  ///< what a refusal means; kOmitted: not written
    /// The entry is read first and written only if it differs, then read back: WriteIgnored, or SyncObject if
    /// mandatory, when it keeps another value. Numbers of at most four bytes.
    bool compared = false;

    /// Step that writes `value` in wire byte order.
    template <typename T>
    static Step of(std::uint16_t index, std::uint8_t subindex, T value) {
      const auto bytes = bytes::to_le_bytes(value);
      return {{index, subindex, false}, {bytes.begin(), bytes.end()}};
    }
  };
  std::vector<Step> steps;  ///< writes, in order
};

/// Writes the scripts of several slaves: each script in order, the slaves in parallel. A script ends at its first
/// failure, the others continue. Returns one result per script.
///
/// When a slave aborts an optional step, or a compared entry keeps another value, its further steps of that object are
/// left out, the compared entries of the object that were written get back their values, and this is added to `notes`
/// (null: to none). Other failures than aborts are errors in optional steps as well.
[[nodiscard]] std::vector<Result<void>> run_scripts(MailboxEngine& engine, std::span<const SdoScript> scripts,
                                                    StartupNotes* notes = nullptr);

}  // namespace driveline::ecat_master
