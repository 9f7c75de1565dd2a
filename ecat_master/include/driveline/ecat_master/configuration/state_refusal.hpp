#pragma once

#include <chrono>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"

namespace driveline::ecat_master {

/// Longest time for which the drives of a slave are asked why it refused a state.
inline constexpr std::chrono::seconds kRefusalReadingTime{2};
/// Most operation data of a drive whose names, values and limits are read after a refusal; of the others only the
/// number is noted.
inline constexpr std::size_t kMostRefusalData = 8;

/// Asks the drives of a slave that has refused SAFEOP or OP for the reason, over SoE: for SAFEOP the operation data in
/// S-0-0021 (invalid for phase 2), for OP those in S-0-0022 and S-0-0023 (invalid for phases 3 and 4), and in both
/// cases the diagnostic message S-0-0095 (IEC 61800-7-204). Adds a notes::DatumRefusesState per operation datum and a
/// notes::DriveDiagnosis per drive to `notes`, and the first operation datum to the returned error.
///
/// The drives may have none of these IDNs, and may answer with anything: failures are passed over, and the questions
/// end after kRefusalReadingTime. Returns other errors, and those about slaves without SoE, unchanged. Not \rtsafe.
[[nodiscard]] Error explain_by_drives(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                      const Error& error, StartupNotes& notes);

}  // namespace driveline::ecat_master
