#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Type of the value of an object, as users name it.
enum class ValueType {
  kRaw,
  kBool,
  kUint8,
  kUint16,
  kUint32,
  kUint64,
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kFloat,
  kDouble,
  kString,
  kUnicode
};

/// "uint16", "int32", "float", "string" ... as in the IgH tool; empty means raw bytes. Error: a sentence.
[[nodiscard]] Result<ValueType> parse_type(std::string_view name);

/// All names parse_type() knows, for the command line.
[[nodiscard]] std::vector<std::string_view> type_names();

/// The name that parse_type() knows.
[[nodiscard]] std::string_view type_name(ValueType type) noexcept;

/// How values of a CoE data type (its index in the dictionary, ETG.1000.6 Table 64) are written; nothing for types
/// that have no form of their own.
[[nodiscard]] std::optional<ValueType> value_type_of(std::uint16_t data_type) noexcept;

/// Bytes of a value of the type, 0: any number.
[[nodiscard]] std::size_t type_bytes(ValueType type) noexcept;

/// Value of an object.
using TypedValue = std::variant<bool, std::uint64_t, std::int64_t, float, double, std::string>;

/// Value of an object: integers as numbers with their sign, texts up to the first zero, raw bytes as hex digits. Error:
/// the object has another size than the type.
[[nodiscard]] Result<TypedValue> decode_value(std::span<const std::byte> data, ValueType type);

/// The same as text, as the IgH tool prints it: integers as bit pattern and number ("0xfffe -2"), raw bytes in hex
/// ("0x02 0x00"). Error: as above.
[[nodiscard]] Result<std::string> format_value(std::span<const std::byte> data, ValueType type);

/// Bytes of a value given as text: decimal or 0x hexadecimal numbers, hex digits for raw bytes. Error: a sentence.
[[nodiscard]] Result<std::vector<std::byte>> parse_value(std::string_view text, ValueType type);

}  // namespace driveline::runtime
