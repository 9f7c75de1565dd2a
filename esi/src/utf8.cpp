#include "utf8.hpp"

#include <cstddef>
#include <cstdint>

namespace driveline::esi {
namespace {

struct Sequence {
  std::size_t length;  ///< bytes
  char32_t first;      ///< payload bits of the first byte
  char32_t smallest;   ///< smallest code point that needs this length
};

/// Returns length and first bits of the sequence that starts with `lead`; length 0 when `lead` cannot start a sequence.
Sequence sequence_of(std::uint8_t lead) {
  if (lead < 0x80) return {1, lead, 0};
  if ((lead & 0xE0U) == 0xC0U) return {2, lead & 0x1FU, 0x80};
  if ((lead & 0xF0U) == 0xE0U) return {3, lead & 0x0FU, 0x800};
  if ((lead & 0xF8U) == 0xF0U) return {4, lead & 0x07U, 0x10000};
  return {0, 0, 0};
}

bool is_valid_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const Sequence sequence = sequence_of(static_cast<std::uint8_t>(text[at]));
    if (sequence.length == 0 || sequence.length > text.size() - at) return false;
    char32_t point = sequence.first;
    for (std::size_t i = 1; i < sequence.length; ++i) {
      const auto byte = static_cast<std::uint8_t>(text[at + i]);
      if ((byte & 0xC0U) != 0x80U) return false;
      point = (point << 6) | (byte & 0x3FU);
    }
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    if (point < sequence.smallest || point > 0x10FFFF || surrogate) return false;
    at += sequence.length;
  }
  return true;
}

void append_point(std::string& text, char32_t point) {
  const auto tail = [&text, point](unsigned shift) { text += static_cast<char>(0x80U | ((point >> shift) & 0x3FU)); };
  if (point < 0x80) {
    text += static_cast<char>(point);
  } else if (point < 0x800) {
    text += static_cast<char>(0xC0U | (point >> 6));
    tail(0);
  } else if (point < 0x10000) {
    text += static_cast<char>(0xE0U | (point >> 12));
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xF0U | (point >> 18));
    tail(12);
    tail(6);
    tail(0);
  }
}

/// Converts UTF-16 without byte order mark; `high` is the position of the high byte in a code unit. Invalid units
/// become the replacement character.
std::string from_utf16(std::string_view text, std::size_t high) {
  constexpr char32_t kReplacement = 0xFFFD;
  const auto unit = [&](std::size_t at) -> char32_t {
    return static_cast<char32_t>(static_cast<std::uint8_t>(text[at + high])) << 8 |
           static_cast<std::uint8_t>(text[at + 1 - high]);
  };
  std::string converted;
  for (std::size_t at = 0; at + 1 < text.size(); at += 2) {
    char32_t point = unit(at);
    const bool pair =
        point >= 0xD800 && point < 0xDC00 && at + 3 < text.size() && unit(at + 2) >= 0xDC00 && unit(at + 2) < 0xE000;
    if (pair) {
      point = 0x10000 + ((point - 0xD800) << 10) + (unit(at + 2) - 0xDC00);
      at += 2;
    } else if (point >= 0xD800 && point < 0xE000) {
      point = kReplacement;
    }
    append_point(converted, point);
  }
  return converted;
}

}  // namespace

std::string to_utf8(std::string_view text) {
  if (text.starts_with("\xFF\xFE")) return from_utf16(text.substr(2), 1);
  if (text.starts_with("\xFE\xFF")) return from_utf16(text.substr(2), 0);
  if (is_valid_utf8(text)) return std::string(text);
  std::string converted;
  for (const char c : text) {
    const auto byte = static_cast<std::uint8_t>(c);
    if (byte < 0x80) {
      converted += c;
    } else {
      converted += static_cast<char>(0xC0U | (byte >> 6));
      converted += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return converted;
}

}  // namespace driveline::esi
