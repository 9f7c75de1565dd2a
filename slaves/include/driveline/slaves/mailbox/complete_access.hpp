#pragma once

#include <span>

#include "driveline/slaves/od/object_dictionary.hpp"

/// Whole objects in one SDO transfer (complete access, ETG.1000.6 5.6.2): sub-index 0 padded to 16 bits, behind it the
/// other sub-indices at their bit offsets; from sub-index 1, the same without the first 16 bits.
namespace driveline::slaves {

/// Bytes of a whole object with all its sub-indices from `first` (0 or 1) on.
[[nodiscard]] std::size_t complete_size(std::span<const EntryRow> rows, std::uint8_t first) noexcept;

/// Uploads the object: as many sub-indices as its entry 0 counts; those that cannot be read are zero. Returns the bytes
/// written to `out`, which holds complete_size(). Aborts: variables and sub-indices above 1 cannot be accessed
/// completely (06010000h), no entry can be read (06010001h, 08000022h).
[[nodiscard]] SdoResult<std::size_t> upload_complete(const ObjectDictionary& dictionary, std::uint16_t index,
                                                     std::uint8_t first, AccessPhase phase, std::span<std::byte> out);

/// Can the object be written completely now? Returns the most bytes it takes.
[[nodiscard]] SdoResult<std::size_t> writable_complete(const ObjectDictionary& dictionary, std::uint16_t index,
                                                       std::uint8_t first, AccessPhase phase);

/// Downloads the object as one: all entries that can be written take their values, or none does. Read-only entries
/// pass over theirs. A writable entry 0 is set to 0 first and to its value last, the order that PDO mappings and
/// assignments ask for (ETG.1000.6 5.6.7), and counts the entries that must be in `data`.
[[nodiscard]] SdoResult<void> download_complete(ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t first,
                                                AccessPhase phase, std::span<const std::byte> data,
                                                DictionaryOwner& owner);

}  // namespace driveline::slaves
