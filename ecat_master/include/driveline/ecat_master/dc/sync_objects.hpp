#pragma once

#include <optional>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/coe/sdo_script.hpp"
#include "driveline/ecat_master/dc/sync_signals.hpp"

namespace driveline::ecat_master::dc {

/// Synchronisation types in 1C32h:01 and 1C33h:01 (ETG.1020 6.2).
inline constexpr std::uint16_t kSyncTypeFreeRun = 0;
inline constexpr std::uint16_t kSyncTypeSync0 = 2;  ///< synchronised by SYNC0

/// Writes to the application of a slave in PREOP how it is synchronised: type (1C32h:01, 1C33h:01) and cycle (sub-index
/// 02) of outputs and inputs. Each entry is read first, written only if it differs, and read back. A read-only cycle is
/// not checked.
///
/// With `need` kOptional a slave may lack these objects, keep another value, or refuse the writes, as slaves do that
/// take their synchronisation from the activated signals (AssignActivate): each such entry is added to `notes`, and the
/// slave decides in the transition to SAFEOP. With kMandatory they are errors: SdoAbort, or SyncObject for an entry
/// that reads back differently. Other errors: those of the transfer. Not real-time safe.
[[nodiscard]] Result<void> write_sync_objects(MailboxEngine& engine, std::uint16_t slave, const SyncSignals& signals,
                                              motion::WriteNeed need, StartupNotes& notes);

/// Time from the outputs to SYNC0 as measured by the slave since it entered OP (ETG.1020, 1C32h).
struct SyncMarginReport {
  std::chrono::nanoseconds shortest{0};  ///< sub-index 11h: shortest time from complete outputs to SYNC0
  std::chrono::nanoseconds longest{0};   ///< sub-index 12h: longest time from complete outputs to SYNC0
  std::uint32_t missed = 0;              ///< sub-index 0Bh: SYNC0 pulses without new outputs
};

/// Reads the report of a slave; empty when the slave does not have these entries. Errors: those of the transfer. Not
/// real-time safe.
[[nodiscard]] Result<std::optional<SyncMarginReport>> read_sync_margin(CoeClient& coe);

}  // namespace driveline::ecat_master::dc
