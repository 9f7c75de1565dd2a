#pragma once

#include <span>

#include "driveline/slaves/od/object_dictionary.hpp"

/// Transfer of whole objects by SDO (complete access, ETG.1000.6 5.6.2): sub-index 0 padded to 16 bits, then the other
/// sub-indices at their bit offsets; a transfer from sub-index 1 omits the first 16 bits.
namespace driveline::slaves {

/// Returns the size in bytes of an object with all its sub-indices from `first` (0 or 1) on.
[[nodiscard]] std::size_t complete_size(std::span<const EntryRow> rows, std::uint8_t first) noexcept;

/// Uploads the sub-indices of an object that its entry 0 counts; entries that cannot be read are zero. Returns the
/// number of bytes written to `out`, whose size is at least complete_size(). Aborts: no complete access to variables
/// and from sub-indices above 1 (06010000h), no readable entry (06010001h, 08000022h).
[[nodiscard]] SdoResult<std::size_t> upload_complete(const ObjectDictionary& dictionary, std::uint16_t index,
                                                     std::uint8_t first, AccessPhase phase, std::span<std::byte> out);

/// Checks whether the object can be written completely in this phase. Returns the maximum number of bytes.
[[nodiscard]] SdoResult<std::size_t> writable_complete(const ObjectDictionary& dictionary, std::uint16_t index,
                                                       std::uint8_t first, AccessPhase phase);

/// Downloads an object as a unit: writes all writable entries, or none. The data of read-only entries are skipped. A
/// writable entry 0 is set to 0 first and to its value last, as PDO mappings and assignments require (ETG.1000.6
/// 5.6.7); its value is the number of entries that `data` must contain.
[[nodiscard]] SdoResult<void> download_complete(ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t first,
                                                AccessPhase phase, std::span<const std::byte> data,
                                                DictionaryOwner& owner);

}  // namespace driveline::slaves
