#pragma once

#include "driveline/slaves/msd/variant.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"
#include "driveline/slaves/od/pdo_map.hpp"

namespace driveline::slaves::msd {

/// Four PDOs per direction, eight objects and eight bytes each (MSD manual 8.3.3, 9.1).
inline constexpr PdoLimits kPdoLimits{};

inline constexpr std::uint32_t kVendorId = 0x00000028;  ///< Moog
inline constexpr std::uint32_t kProductCode = facts(Variant::kMsd).product_code;
inline constexpr std::uint32_t kRevision = facts(Variant::kMsd).revision;

/// The object dictionary of a variant: one table for SDO, SDO information, PDO mapping, ESI, SII.
[[nodiscard]] const DictionaryTable& dictionary_table(Variant variant = Variant::kMsd);

/// Parts of the table by address range (1000h-1FFFh, 2000h-5FFFh, 6000h-67FFh) and, for the modes of operation, by use.
[[nodiscard]] std::span<const EntryRow> communication_rows();
[[nodiscard]] std::span<const EntryRow> parameter_rows();
[[nodiscard]] std::span<const EntryRow> profile_rows();
[[nodiscard]] std::span<const EntryRow> mode_rows();
[[nodiscard]] std::span<const EntryRow> terminal_rows();
[[nodiscard]] std::span<const EntryRow> function_rows();

/// What ESI and SII say about the drive, made from the table.
[[nodiscard]] esi::DeviceDescription device_description(Variant variant = Variant::kMsd);

/// The same for ESI files: with mappings for the modes of operation, as proposals for configuration tools (ours; the
/// drive itself comes with empty PDOs).
[[nodiscard]] esi::DeviceDescription esi_description(Variant variant = Variant::kMsd);

/// All rows of the table as a page of Markdown.
[[nodiscard]] std::string object_reference(Variant variant = Variant::kMsd);

}  // namespace driveline::slaves::msd
