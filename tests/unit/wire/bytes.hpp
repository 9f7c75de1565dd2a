#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace driveline::wire::test {

using Bytes = std::vector<std::byte>;

/// Bytes from hexadecimal digits; white space is ignored.
inline Bytes bytes_of(std::string_view hex) {
  Bytes bytes;
  unsigned value = 0;
  unsigned digits = 0;
  for (const char c : hex) {
    if (c == ' ' || c == '\n') continue;
    const unsigned digit = c <= '9' ? static_cast<unsigned>(c - '0') : static_cast<unsigned>((c | 0x20) - 'a' + 10);
    value = ((value << 4) | digit) & 0xFFU;
    if (++digits % 2 == 0) bytes.push_back(static_cast<std::byte>(value));
  }
  return bytes;
}

}  // namespace driveline::wire::test
