#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// One FMMU entity: 16 bytes at 0x0600 + 16 n (ETG.1000.4 Table 56). Maps `length` bytes of the logical process
/// image, bit-granular at both ends, to physical memory of the slave.
struct FmmuEntity {
  static constexpr std::size_t kSize = 16;          ///< size on the wire, in bytes
  static constexpr std::uint8_t kTypeRead = 0x01;   ///< `type`: logical reads read the slave's memory
  static constexpr std::uint8_t kTypeWrite = 0x02;  ///< `type`: logical writes write the slave's memory

  std::uint32_t logical_start = 0;      ///< first byte in the process image
  std::uint16_t length = 0;             ///< bytes touched in the logical image
  std::uint8_t logical_start_bit = 0;   ///< 0..7
  std::uint8_t logical_stop_bit = 7;    ///< 0..7
  std::uint16_t physical_start = 0;     ///< first byte in the slave's memory
  std::uint8_t physical_start_bit = 0;  ///< 0..7
  std::uint8_t type = 0;                ///< kTypeRead and/or kTypeWrite
  bool active = false;                  ///< an inactive entity maps nothing

  /// The three reserved bytes at the end are written as zero.
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 4>(), logical_start);
    bytes::store_le(out.subspan<4, 2>(), length);
    bytes::store_le(out.subspan<6, 1>(), logical_start_bit);
    bytes::store_le(out.subspan<7, 1>(), logical_stop_bit);
    bytes::store_le(out.subspan<8, 2>(), physical_start);
    bytes::store_le(out.subspan<10, 1>(), physical_start_bit);
    bytes::store_le(out.subspan<11, 1>(), type);
    bytes::store_le<std::uint8_t>(out.subspan<12, 1>(), active ? 1 : 0);
    for (std::size_t i = 13; i < kSize; ++i) out[i] = std::byte{0};
  }
  /// Reserved bits are ignored, as slave controllers do.
  [[nodiscard]] static constexpr Decoded<FmmuEntity> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    FmmuEntity fmmu;
    fmmu.logical_start = bytes::load_le<std::uint32_t>(in);
    fmmu.length = bytes::load_le<std::uint16_t>(in.subspan(4));
    fmmu.logical_start_bit = bytes::load_le<std::uint8_t>(in.subspan(6)) & 7U;
    fmmu.logical_stop_bit = bytes::load_le<std::uint8_t>(in.subspan(7)) & 7U;
    fmmu.physical_start = bytes::load_le<std::uint16_t>(in.subspan(8));
    fmmu.physical_start_bit = bytes::load_le<std::uint8_t>(in.subspan(10)) & 7U;
    fmmu.type = bytes::load_le<std::uint8_t>(in.subspan(11)) & 3U;
    fmmu.active = (std::to_integer<unsigned>(in[12]) & 1U) != 0;
    return fmmu;
  }
  constexpr bool operator==(const FmmuEntity&) const = default;
};

}  // namespace driveline::wire
