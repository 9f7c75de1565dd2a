#pragma once

#include <array>
#include <span>
#include <vector>

#include "driveline/esi/eds_file.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"

namespace driveline::slaves::msd {

/// Bit rates of P 2006 in kbit/s (MSD manual 4.6.3).
inline constexpr std::array<std::uint16_t, 6> kCanBitRates{20, 50, 125, 250, 500, 1000};
/// PDOs per direction (MSD manual 8.1.1).
inline constexpr std::size_t kCanPdos = 4;

/// Returns the object dictionary of a variant on a CAN bus: the rows of the drive, those of CANopen, and 6502h without
/// the modes that exist on EtherCAT only.
[[nodiscard]] const DictionaryTable& can_dictionary_table(Variant variant = Variant::kMsd);

/// Returns the rows that belong to CANopen: 1005h to 1017h, the PDOs, and P 2005 to P 2062 (MSD manual Table 8.1).
[[nodiscard]] std::vector<EntryRow> can_rows(Variant variant);

/// Returns the description of a variant on a CAN bus, for an EDS: objects, COB-IDs that count from the node-ID, bit
/// rates.
[[nodiscard]] esi::EdsFile can_description(Variant variant = Variant::kMsd);

}  // namespace driveline::slaves::msd
