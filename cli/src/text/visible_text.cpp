#include "text/visible_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace driveline::cli {
namespace {

constexpr std::uint32_t kDelete = 0x7F;
constexpr std::uint32_t kControlsEnd = 0x20;       ///< C0: control characters below the space
constexpr std::uint32_t kUpperControlsEnd = 0xA0;  ///< C1: 80h to 9Fh; 9Bh starts an escape sequence like ESC [
constexpr std::uint32_t kSurrogates = 0xD800;      ///< up to DFFFh: no characters
constexpr std::uint32_t kSurrogatesEnd = 0xE000;
constexpr std::uint32_t kCharactersEnd = 0x11'0000;

/// A character of UTF-8, and its number of bytes; none: the first byte starts no character.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};

unsigned visible_byte(std::string_view text, std::size_t n) noexcept {
  return static_cast<unsigned char>(text[n]);
}

Character first_character(std::string_view text) noexcept {
  const unsigned first = visible_byte(text, 0);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = (first & 0xE0U) == 0xC0 ? 2 : (first & 0xF0U) == 0xE0 ? 3 : (first & 0xF8U) == 0xF0 ? 4 : 0;
  if (bytes == 0 || text.size() < bytes) return {};
  std::uint32_t code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((visible_byte(text, i) & 0xC0U) != 0x80) return {};
    code = code << 6 | (visible_byte(text, i) & 0x3FU);
  }
  // Overlong encodings are invalid: they would hide characters from a search.
  constexpr std::uint32_t kSmallestCode[] = {0x80, 0x800, 0x1'0000};
  const bool valid =
      code >= kSmallestCode[bytes - 2] && code < kCharactersEnd && (code < kSurrogates || code >= kSurrogatesEnd);
  return valid ? Character{code, bytes} : Character{};
}

bool is_control(std::uint32_t code) noexcept {
  if (code == '\n' || code == '\t') return false;
  return code < kControlsEnd || (code >= kDelete && code < kUpperControlsEnd);
}

std::string without_controls(std::string_view text, std::string (*shown)(std::uint32_t code)) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const auto character = first_character(text);
    const auto bytes = std::max<std::size_t>(character.bytes, 1);
    if (character.bytes == 0) {
      result += shown(visible_byte(text, 0));
    } else if (is_control(character.code)) {
      result += shown(character.code);
    } else {
      result += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return result;
}

}  // namespace

std::string visible_text(std::string_view text) {
  return without_controls(text, [](std::uint32_t code) { return fmt::format("\\x{:02X}", code); });
}

std::string visible_json(std::string_view document) {
  return without_controls(document, [](std::uint32_t code) { return fmt::format("\\u{:04X}", code); });
}

}  // namespace driveline::cli
