#pragma once

#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves {

/// Whether the mapping contains settings: entries that "store parameters" stores. \rtsafe
[[nodiscard]] bool has_settings(const PdoMap& map) noexcept;

/// Like PdoMap::decode(), but settings act as if they were written by SDO: the owner is told of new values, and a
/// device parameter keeps its value if an SDO would refuse the new one. Only the first 64 entries of a mapping can be
/// settings. \rtsafe
void decode_settings(const PdoMap& map, std::span<const std::byte> data, ObjectDictionary& dictionary,
                     DictionaryOwner& owner) noexcept;

}  // namespace driveline::slaves
