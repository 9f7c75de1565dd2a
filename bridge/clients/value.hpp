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

/// A decoded value. Strings point into the bytes of the sample.
struct Value {
  const Field* field = nullptr;  ///< null: a whole sample
  const StructType* structure = nullptr;
  bool sequence = false;  ///< a sequence or an array
  /// Set if neither a structure nor a sequence; an enumeration has its number, even an unknown one.
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string_view> scalar;
  std::vector<Value> parts;  ///< fields of a structure, or elements of a sequence or an array

  /// Finds a field of a structure; null if there is none of that name.
  [[nodiscard]] const Value* find(std::string_view name) const noexcept;
  /// Value of a scalar; 0 if it is not a number. An enumeration returns its number.
  [[nodiscard]] double number() const noexcept;
  [[nodiscard]] std::uint64_t whole() const noexcept;  ///< like number(), negative values in two's complement
  /// Text of a string, or name of an enumeration value; otherwise empty.
  [[nodiscard]] std::string_view text() const noexcept;
};

/// Bytes that are not a sample of a type.
struct NotDecoded {
  std::size_t bytes;      ///< number of bytes
  std::string_view type;  ///< type name in ROS 2
};
/// The error as a sentence.
[[nodiscard]] std::string describe(const NotDecoded& error);

/// Decodes a sample: plain CDR after its encapsulation header (RTPS 2.2, 10.2), in either byte order.
[[nodiscard]] tl::expected<Value, NotDecoded> decode(const StructType& structure, Bytes sample);

/// Reads one integer field of a sample by name, without decoding the fields after it; nullopt if the sample is too
/// short or has no such field.
[[nodiscard]] std::optional<std::uint64_t> whole_field(const StructType& structure, Bytes sample,
                                                       std::string_view name);

/// Key of a sample as RTPS compares it (RTPS 2.2, 9.6.3.8): its key fields in big-endian order, padded with zeros.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> key_of(const StructType& structure, Bytes sample);

}  // namespace driveline::bridge::clients
