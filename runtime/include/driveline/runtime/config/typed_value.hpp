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

/// Type of the value of an object, as named by users.
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

/// Reads "uint16", "int32", "float", "string" ... as in the IgH tool; empty means raw bytes. Error: a sentence.
[[nodiscard]] Result<ValueType> parse_type(std::string_view name);

/// Returns all names that parse_type() accepts, for the command line.
[[nodiscard]] std::vector<std::string_view> type_names();

/// Returns the name of the type for parse_type().
[[nodiscard]] std::string_view type_name(ValueType type) noexcept;

/// Returns the value type of a CoE data type (its index in the dictionary, ETG.1000.6 Table 64); none for types without
/// a text form of their own.
[[nodiscard]] std::optional<ValueType> value_type_of(std::uint16_t data_type) noexcept;

/// Returns the bytes of a value of the type; 0: any number.
[[nodiscard]] std::size_t type_bytes(ValueType type) noexcept;

/// Value of an object.
using TypedValue = std::variant<bool, std::uint64_t, std::int64_t, float, double, std::string>;

/// Decodes the value of an object: integers as numbers with their sign, texts up to the first zero, raw bytes as hex
/// digits. Error: the size of the object differs from that of the type.
[[nodiscard]] Result<TypedValue> decode_value(std::span<const std::byte> data, ValueType type);

/// Same as text, in the format of the IgH tool: integers as bit pattern and number ("0xfffe -2"), raw bytes in hex
/// ("0x02 0x00"). Error: as above.
[[nodiscard]] Result<std::string> format_value(std::span<const std::byte> data, ValueType type);

/// Returns the bytes of a value given as text: decimal or 0x hexadecimal numbers, hex digits for raw bytes. Error: a
/// sentence.
[[nodiscard]] Result<std::vector<std::byte>> parse_value(std::string_view text, ValueType type);

}  // namespace driveline::runtime
