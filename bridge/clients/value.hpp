#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "schema.hpp"

namespace driveline::bridge::clients {

using Bytes = std::span<const std::uint8_t>;

/// A decoded value. Strings point into the bytes that it was decoded from.
struct Value {
  const Field* field = nullptr;  ///< null: a whole sample
  const StructType* structure = nullptr;
  bool sequence = false;  ///< or an array
  /// Of what is neither a structure nor a sequence; an enumeration has its number, an unknown one too.
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string_view> scalar;
  std::vector<Value> parts;  ///< by field of a structure; elements of a sequence or an array

  /// A field of a structure; null: there is none of that name.
  [[nodiscard]] const Value* find(std::string_view name) const noexcept;
  /// Of a scalar; 0 of what is no number. An enumeration is its number.
  [[nodiscard]] double number() const noexcept;
  [[nodiscard]] std::uint64_t whole() const noexcept;  ///< as number(), negative ones in two's complement
  /// Of a string, or the name of an enumeration's value; empty of anything else.
  [[nodiscard]] std::string_view text() const noexcept;
};

/// Bytes that are no sample of a type.
struct NotDecoded {
  std::size_t bytes;      ///< how many
  std::string_view type;  ///< as ROS 2 has it
};
/// As a sentence.
[[nodiscard]] std::string describe(const NotDecoded& error);

/// Decodes a sample: plain CDR behind its encapsulation header (RTPS 2.2, 10.2), in either byte order.
[[nodiscard]] tl::expected<Value, NotDecoded> decode(const StructType& structure, Bytes sample);

/// One whole number of a sample, by the name of a field, without the fields behind it; nothing where the sample is too
/// short or has no such field.
[[nodiscard]] std::optional<std::uint64_t> whole_field(const StructType& structure, Bytes sample,
                                                       std::string_view name);

/// The key of a sample as RTPS compares it (RTPS 2.2, 9.6.3.8): its fields in big endian, filled up with zeros.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> key_of(const StructType& structure, Bytes sample);

}  // namespace driveline::bridge::clients
