#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/esi/device_description.hpp"

namespace driveline::esi {

/// Returns the name of a base data type in ESI files (ETG.1020 base data types): "UDINT", "STRING(8)", "ARRAY [0..3] OF
/// BYTE". String names contain the length, so the name depends on the number of bits.
[[nodiscard]] std::string data_type_name(DataType type, std::uint32_t bit_length);

/// Returns the base data type with this name; BYTE, WORD, DWORD and the bit arrays count as unsigned numbers of their
/// size. Returns nullopt for names of device-specific types.
[[nodiscard]] std::optional<DataType> data_type_of(std::string_view name);

/// Returns the unsigned number or bit field of exactly this many bits; nullopt when there is none.
[[nodiscard]] std::optional<DataType> unsigned_type(std::uint32_t bit_length);

}  // namespace driveline::esi
