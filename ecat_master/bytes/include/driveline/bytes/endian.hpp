#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

/// Little-endian loads and stores, the only functions that convert bytes of a frame to numbers (ETG.1000.4 5.2: all
/// EtherCAT fields are little endian; only the Ethernet header is big endian).
namespace driveline::bytes {

template <typename T>
concept Integer = std::integral<T> && !std::same_as<T, bool>;

/// Reads a little-endian integer from the first sizeof(T) bytes. Precondition: `bytes.size() >= sizeof(T)`. \rtsafe
template <Integer T>
[[nodiscard]] constexpr T load_le(std::span<const std::byte> bytes) noexcept {
  // One load instead of sizeof(T): compilers do not reliably combine the byte loads.
  if (std::endian::native == std::endian::little && !std::is_constant_evaluated()) {
    T native{};
    std::memcpy(&native, bytes.data(), sizeof(T));
    return native;
  }
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  }
  return static_cast<T>(value);
}

/// Writes `value` little endian into the first sizeof(T) bytes. Precondition: `bytes.size() >= sizeof(T)`. \rtsafe
template <Integer T>
constexpr void store_le(std::span<std::byte> bytes, T value) noexcept {
  if (std::endian::native == std::endian::little && !std::is_constant_evaluated()) {
    std::memcpy(bytes.data(), &value, sizeof(T));
    return;
  }
  const auto bits = static_cast<std::uint64_t>(static_cast<std::make_unsigned_t<T>>(value));
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[i] = static_cast<std::byte>(bits >> (8 * i));
  }
}

/// Reads a big-endian 16-bit number (Ethernet header). Precondition: at least 2 bytes. \rtsafe
[[nodiscard]] constexpr std::uint16_t load_be16(std::span<const std::byte> bytes) noexcept {
  return static_cast<std::uint16_t>((std::to_integer<unsigned>(bytes[0]) << 8) | std::to_integer<unsigned>(bytes[1]));
}

/// Writes a big-endian 16-bit number (Ethernet header). Precondition: at least 2 bytes. \rtsafe
constexpr void store_be16(std::span<std::byte> bytes, std::uint16_t value) noexcept {
  bytes[0] = static_cast<std::byte>(value >> 8);
  bytes[1] = static_cast<std::byte>(value & 0xFF);
}

/// The little-endian bytes of an integer, for callers that need a separate buffer. \rtsafe
template <Integer T>
[[nodiscard]] constexpr std::array<std::byte, sizeof(T)> to_le_bytes(T value) noexcept {
  std::array<std::byte, sizeof(T)> bytes{};
  store_le(bytes, value);
  return bytes;
}

}  // namespace driveline::bytes
