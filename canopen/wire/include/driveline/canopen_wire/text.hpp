#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace driveline::canopen {

/// Text of up to `Capacity` characters in the object itself. Characters beyond the capacity are left out.
template <std::size_t Capacity>
class Text {
 public:
  /// Appends a character. \rtsafe
  constexpr Text& add(char character) noexcept {
    if (size_ < Capacity) characters_[size_++] = character;
    return *this;
  }
  /// Appends a text. \rtsafe
  constexpr Text& add(std::string_view text) noexcept {
    for (const char character : text) add(character);
    return *this;
  }
  /// Appends the last `digits` hexadecimal digits of a number, upper case. \rtsafe
  constexpr Text& add_hex(std::uint32_t value, unsigned digits) noexcept {
    while (digits-- > 0) add("0123456789ABCDEF"[value >> 4U * digits & 0xFU]);
    return *this;
  }
  /// Appends a decimal number with leading zeros up to `digits` digits. \rtsafe
  constexpr Text& add_decimal(std::uint64_t value, unsigned digits = 1) noexcept {
    if (value >= 10 || digits > 1) add_decimal(value / 10, digits > 1 ? digits - 1 : 1);
    return add(static_cast<char>('0' + value % 10));
  }
  /// The characters. \rtsafe
  [[nodiscard]] constexpr std::string_view view() const noexcept { return {characters_.data(), size_}; }

 private:
  std::array<char, Capacity> characters_{};
  std::size_t size_ = 0;
};

/// The value of 1 to 8 hexadecimal digits of either case; empty for anything else. \rtsafe
[[nodiscard]] constexpr std::optional<std::uint32_t> hex_number(std::string_view digits) noexcept {
  if (digits.empty() || digits.size() > 8) return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : digits) {
    const auto lower = static_cast<char>(c | 0x20);
    const bool decimal = c >= '0' && c <= '9';
    if (!decimal && (lower < 'a' || lower > 'f')) return std::nullopt;
    value = value << 4U | static_cast<std::uint32_t>(decimal ? c - '0' : lower - 'a' + 10);
  }
  return value;
}

/// The value of 1 to 18 decimal digits; empty for anything else. \rtsafe
[[nodiscard]] constexpr std::optional<std::uint64_t> decimal_number(std::string_view digits) noexcept {
  if (digits.empty() || digits.size() > 18) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + static_cast<std::uint64_t>(c - '0');
  }
  return value;
}

/// Takes the next word off a text whose words are separated by blanks; empty at its end. \rtsafe
[[nodiscard]] constexpr std::string_view next_word(std::string_view& text) noexcept {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return text = {};
  const auto end = std::min(text.find_first_of(kBlanks, begin), text.size());
  const auto word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

}  // namespace driveline::canopen
