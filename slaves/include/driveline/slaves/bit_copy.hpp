#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace driveline::slaves {

/// Copies `count` bits from bit `from_bit` of `from` to bit `to_bit` of `to`; bit 0 is the lowest bit of the first
/// byte, as in process data. Other bits of `to` do not change. Both ranges must lie inside their spans. \rtsafe
void copy_bits(std::span<const std::byte> from, std::size_t from_bit, std::span<std::byte> to, std::size_t to_bit,
               std::size_t count) noexcept;

/// Returns the number in `count` (at most 64) bits starting at `bit`; not sign extended. \rtsafe
[[nodiscard]] std::uint64_t load_bits(std::span<const std::byte> from, std::size_t bit, std::size_t count) noexcept;

/// Stores the lowest `count` (at most 64) bits of `value` at `bit`. \rtsafe
void store_bits(std::span<std::byte> to, std::size_t bit, std::size_t count, std::uint64_t value) noexcept;

/// Returns the two's complement number `value` of `count` bits, sign extended to 64 bits. \rtsafe
[[nodiscard]] constexpr std::uint64_t sign_extended(std::uint64_t value, std::size_t count) noexcept {
  if (count == 0 || count >= 64) return value;
  const std::uint64_t sign = std::uint64_t{1} << (count - 1);
  const std::uint64_t inside = value & ((sign << 1) - 1);
  return (inside ^ sign) - sign;
}

}  // namespace driveline::slaves
