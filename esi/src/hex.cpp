#include "driveline/esi/hex.hpp"

namespace driveline::esi {
namespace {

constexpr std::string_view kDigits = "0123456789ABCDEF";

std::optional<unsigned> digit_value(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A' + 10);
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a' + 10);
  return std::nullopt;
}

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

}  // namespace

std::optional<std::vector<std::byte>> parse_hex(std::string_view text) {
  std::vector<std::byte> bytes;
  unsigned high = 0;
  bool half = false;
  for (const char c : text) {
    if (is_space(c)) continue;
    const auto digit = digit_value(c);
    if (!digit) return std::nullopt;
    if (half) bytes.push_back(static_cast<std::byte>(high << 4 | *digit));
    high = *digit;
    half = !half;
  }
  if (half) return std::nullopt;
  return bytes;
}

std::string to_hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    text += kDigits[std::to_integer<std::size_t>(b >> 4)];
    text += kDigits[std::to_integer<std::size_t>(b & std::byte{0x0F})];
  }
  return text;
}

}  // namespace driveline::esi
