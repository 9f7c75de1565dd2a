#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <span>
#include <type_traits>

#include "driveline/bytes/endian.hpp"

namespace driveline::motion {

/// A byte-aligned entry of the process image: one load or store in the cycle. Created at start-up.
template <typename T>
class PdoEntry {
 public:
  static_assert(bytes::Integer<T> || std::same_as<T, float> || std::same_as<T, double>,
                "integers of 1, 2, 4 or 8 bytes, float (REAL32), double (REAL64); bool for single bits");
  PdoEntry() = default;
  /// `offset`: bytes from the start of the image of inputs or outputs; the entry must lie inside.
  explicit PdoEntry(std::size_t offset) noexcept : offset_(static_cast<std::uint32_t>(offset)) {}
  /// Reads the entry. \rtsafe
  [[nodiscard]] T get(std::span<const std::byte> image) const noexcept {
    return std::bit_cast<T>(bytes::load_le<Raw>(image.subspan(offset_, sizeof(T))));
  }
  /// Writes the entry. \rtsafe
  void set(std::span<std::byte> image, T value) const noexcept {
    bytes::store_le<Raw>(image.subspan(offset_, sizeof(T)), std::bit_cast<Raw>(value));
  }

 private:
  /// Floating point numbers are sent as integers with their IEEE 754 bits.
  using Raw = std::conditional_t<std::same_as<T, float>, std::uint32_t,
                                 std::conditional_t<std::same_as<T, double>, std::uint64_t, T>>;

  /// 32 bits, because an image never reaches 4 GiB, and every axis has a dozen of these in the cycle.
  std::uint32_t offset_ = 0;
};

/// A single bit of the process image.
template <>
class PdoEntry<bool> {
 public:
  PdoEntry() = default;
  /// `bit` 0 to 7 of the byte at `offset`; 0 is the lowest.
  PdoEntry(std::size_t offset, unsigned bit) noexcept : offset_(offset), mask_(static_cast<std::byte>(1U << bit)) {}
  /// Reads the bit. \rtsafe
  [[nodiscard]] bool get(std::span<const std::byte> image) const noexcept {
    return (image[offset_] & mask_) != std::byte{0};
  }
  /// Writes the bit and preserves the other bits of the byte. \rtsafe
  void set(std::span<std::byte> image, bool value) const noexcept {
    auto& byte = image[offset_];
    byte = value ? byte | mask_ : byte & ~mask_;
  }

 private:
  std::size_t offset_ = 0;
  std::byte mask_{1};
};

/// An entry of `bits` bits (1..32) at any bit offset of the process image: for entries that are not whole bytes or not
/// byte-aligned.
class PdoBits {
 public:
  /// Longest entry in bits; it spans five bytes when it starts inside a byte.
  static constexpr unsigned kMaxBits = 32;

  PdoBits() = default;
  /// `bit_offset` counts from bit 0 of the image's first byte, 1 <= bits <= kMaxBits; the entry must lie inside.
  PdoBits(std::size_t bit_offset, unsigned bits) noexcept
      : offset_(bit_offset / 8),
        bytes_(static_cast<unsigned>((bit_offset % 8 + bits + 7) / 8)),
        shift_(static_cast<unsigned>(bit_offset % 8)),
        mask_((std::uint64_t{1} << bits) - 1) {}

  /// Reads the entry. \rtsafe
  [[nodiscard]] std::uint32_t get(std::span<const std::byte> image) const noexcept {
    return static_cast<std::uint32_t>((load(image) >> shift_) & mask_);
  }
  /// Writes the entry. Ignores bits of `value` beyond its length and preserves the surrounding bits. \rtsafe
  void set(std::span<std::byte> image, std::uint32_t value) const noexcept {
    const std::uint64_t raw = (load(image) & ~(mask_ << shift_)) | ((value & mask_) << shift_);
    for (unsigned i = 0; i < bytes_; ++i) image[offset_ + i] = static_cast<std::byte>(raw >> (8 * i) & 0xFF);
  }

 private:
  [[nodiscard]] std::uint64_t load(std::span<const std::byte> image) const noexcept {
    std::uint64_t raw = 0;
    for (unsigned i = 0; i < bytes_; ++i) raw |= std::to_integer<std::uint64_t>(image[offset_ + i]) << (8 * i);
    return raw;
  }

  std::size_t offset_ = 0;
  unsigned bytes_ = 1;
  unsigned shift_ = 0;
  std::uint64_t mask_ = 1;
};

}  // namespace driveline::motion
