#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace driveline::canopen {

/// Reads up to 8 bytes as one number, for comparison with as many bytes. A PDO is so short that a call of memcmp or
/// memcpy costs more than its work, and the cycle compares and copies all of them. \rtsafe
[[nodiscard]] inline std::uint64_t load_few(std::span<const std::byte> from) noexcept {
  const auto count = from.size();
  if (count >= 4) {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::memcpy(&first, from.data(), sizeof first);
    std::memcpy(&last, from.data() + count - sizeof last, sizeof last);
    return std::uint64_t{first} << 32U | last;
  }
  if (count >= 2) {
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    std::memcpy(&first, from.data(), sizeof first);
    std::memcpy(&last, from.data() + count - sizeof last, sizeof last);
    return std::uint64_t{first} << 16U | last;
  }
  return count == 0 ? 0 : std::to_integer<std::uint64_t>(from[0]);
}

/// Copies up to 8 bytes between places that do not overlap. \rtsafe
inline void copy_few(std::span<const std::byte> from, std::byte* to) noexcept {
  const auto count = from.size();
  if (count >= 4) {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::memcpy(&first, from.data(), sizeof first);
    std::memcpy(&last, from.data() + count - sizeof last, sizeof last);
    std::memcpy(to, &first, sizeof first);
    std::memcpy(to + count - sizeof last, &last, sizeof last);
    return;
  }
  if (count >= 2) std::memcpy(to, from.data(), 2);
  if (count % 2 == 1) to[count - 1] = from[count - 1];
}

}  // namespace driveline::canopen
