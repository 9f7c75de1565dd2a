#pragma once

#include "driveline/esi/device_description.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::msd {

/// PDO limits: four PDOs per direction, eight objects and eight bytes each (MSD manual 8.3.3, 9.1).
inline constexpr PdoLimits kPdoLimits{};

/// Returns the object dictionary of a variant: one table for SDO, SDO information, PDO mapping, ESI, SII.
[[nodiscard]] const DictionaryTable& dictionary_table(Variant variant = Variant::kMsd);

/// Returns the rows that belong to EtherCAT: sync managers, PDO mapping and assignment, synchronisation.
[[nodiscard]] std::span<const EntryRow> ethercat_rows();

/// Returns the description for ESI and SII, made from the table.
[[nodiscard]] esi::DeviceDescription device_description(Variant variant = Variant::kMsd);
/// Returns the description for an EEPROM: without the objects, whose list takes longer to create than a drive.
[[nodiscard]] esi::DeviceDescription eeprom_description(Variant variant);

/// Returns the description for ESI files: with mappings for the modes of operation, as proposals for configuration
/// tools (ours; the drive itself is delivered with empty PDOs).
[[nodiscard]] esi::DeviceDescription esi_description(Variant variant = Variant::kMsd);

/// Returns all rows of the table as a Markdown page.
[[nodiscard]] std::string object_reference(Variant variant = Variant::kMsd);

}  // namespace driveline::slaves::msd
