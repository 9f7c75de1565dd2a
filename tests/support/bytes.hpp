#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace driveline::bytes_test {

/// Converts hex digits to bytes; skips blanks.
[[nodiscard]] inline std::vector<std::byte> hex(std::string_view text) {
  std::vector<std::byte> bytes;
  int digits = 0;
  unsigned value = 0;
  for (const char c : text) {
    if (c == ' ') continue;
    const auto digit = static_cast<unsigned>(c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10);
    value = value << 4 | digit;
    if (++digits % 2 == 0) bytes.push_back(static_cast<std::byte>(value & 0xFFU));
  }
  return bytes;
}

[[nodiscard]] inline std::vector<std::byte> copy_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace driveline::bytes_test
