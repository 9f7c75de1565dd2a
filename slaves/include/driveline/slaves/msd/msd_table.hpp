#pragma once

#include "driveline/esi/device_description.hpp"
#include "driveline/slaves/msd/variant.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::msd {

/// Four PDOs per direction, eight objects and eight bytes each (MSD manual 8.3.3, 9.1).
inline constexpr PdoLimits kPdoLimits{};

inline constexpr std::uint32_t kVendorId = 0x00000028;  ///< Moog
/// 1018h:02 of the MSD; other variants have their own
inline constexpr std::uint32_t kProductCode = facts(Variant::kMsd).product_code;
inline constexpr std::uint32_t kRevision = facts(Variant::kMsd).revision;  ///< 1018h:03 of the MSD

/// The object dictionary of a variant: one table for SDO, SDO information, PDO mapping, ESI, SII.
[[nodiscard]] const DictionaryTable& dictionary_table(Variant variant = Variant::kMsd);

/// Parts of the table by address range (1000h-1FFFh, 2000h-5FFFh, 6000h-67FFh) and, for the modes of operation, by use.
[[nodiscard]] std::span<const EntryRow> communication_rows();
/// Manufacturer's parameters, 2000h-5FFFh.
[[nodiscard]] std::span<const EntryRow> parameter_rows();
/// CiA 402 objects that every mode uses.
[[nodiscard]] std::span<const EntryRow> profile_rows();
/// Objects of single modes of operation and of the units.
[[nodiscard]] std::span<const EntryRow> mode_rows();
/// Function selectors and images of the terminals, the motor brake.
[[nodiscard]] std::span<const EntryRow> terminal_rows();
/// Touch probe, warnings, protection of the motor, actual values in units of people.
[[nodiscard]] std::span<const EntryRow> function_rows();

/// What ESI and SII say about the drive, made from the table.
[[nodiscard]] esi::DeviceDescription device_description(Variant variant = Variant::kMsd);
/// What of it an EEPROM holds: all but the objects, which cost more to list than a drive to build.
[[nodiscard]] esi::DeviceDescription eeprom_description(Variant variant);

/// The same for ESI files: with mappings for the modes of operation, as proposals for configuration tools (ours; the
/// drive itself comes with empty PDOs).
[[nodiscard]] esi::DeviceDescription esi_description(Variant variant = Variant::kMsd);

/// All rows of the table as a page of Markdown.
[[nodiscard]] std::string object_reference(Variant variant = Variant::kMsd);

}  // namespace driveline::slaves::msd
