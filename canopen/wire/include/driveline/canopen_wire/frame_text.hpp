#pragma once

#include "driveline/canopen_wire/frame.hpp"
#include "driveline/canopen_wire/text.hpp"

namespace driveline::canopen {

/// Appends an identifier: 3 hexadecimal digits of a base one, 8 of an extended one. \rtsafe
template <std::size_t Capacity>
constexpr void add_identifier(Text<Capacity>& text, Identifier identifier) noexcept {
  text.add_hex(identifier.value, identifier.extended ? 8 : 3);
}

/// Appends bytes as pairs of hexadecimal digits. \rtsafe
template <std::size_t Capacity>
constexpr void add_bytes(Text<Capacity>& text, std::span<const std::byte> bytes) noexcept {
  for (const std::byte byte : bytes) text.add_hex(std::to_integer<std::uint32_t>(byte), 2);
}

/// Reads an identifier whose format is told by its length: more than three digits are an extended one. Empty: no
/// hexadecimal number, or more than the format has bits. \rtsafe
[[nodiscard]] constexpr std::optional<Identifier> parse_identifier(std::string_view digits) noexcept {
  const auto value = hex_number(digits);
  if (!value) return std::nullopt;
  const Identifier identifier{*value, digits.size() > 3};
  return identifier.valid() ? std::optional(identifier) : std::nullopt;
}

/// Reads up to eight bytes as pairs of hexadecimal digits into a data frame; empty for anything else. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> parse_data(Identifier identifier, std::string_view digits) noexcept {
  if (digits.size() % 2 != 0 || digits.size() > 2 * Frame::kMaxLength) return std::nullopt;
  Frame frame{identifier};
  for (; !digits.empty(); digits.remove_prefix(2)) {
    const auto byte = hex_number(digits.substr(0, 2));
    if (!byte) return std::nullopt;
    frame.data[frame.length++] = static_cast<std::byte>(*byte);
  }
  return frame;
}

}  // namespace driveline::canopen
