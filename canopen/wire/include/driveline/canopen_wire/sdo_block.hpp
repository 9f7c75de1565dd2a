#pragma once

#include "driveline/canopen_wire/sdo.hpp"

namespace driveline::canopen {

/// SDO block transfer (CiA 301 7.2.4.3.9 to .16): up to 127 segments of 7 bytes between two confirmations.
namespace sdo_block {
inline constexpr std::size_t kMaxSegments = 127;  ///< most segments of a sub-block

/// Sub-command, bits 0-1 of requests to upload.
inline constexpr unsigned kUploadInitiate = 0;
inline constexpr unsigned kUploadEnd = 1;      ///< of both sides
inline constexpr unsigned kUploadConfirm = 2;  ///< client: sequence number of the last good segment, next block size
inline constexpr unsigned kUploadStart = 3;    ///< client: send the first sub-block

/// Sub-command of requests to download, bit 0.
inline constexpr unsigned kDownloadInitiate = 0;
inline constexpr unsigned kDownloadEnd = 1;
/// Sub-command of answers to a download, bits 0-1.
inline constexpr unsigned kDownloadConfirm = 2;

inline constexpr unsigned kSizeIndicated = 0x02;  ///< bit 1 of an initiate: bytes 4-7 hold the size
inline constexpr unsigned kCrcSupported = 0x04;   ///< bit 2 of an initiate: the sender can compute the CRC

/// First byte of a segment: "no more segments" in bit 7, sequence number 1 to 127 in bits 0-6.
struct Segment {
  bool last = false;          ///< no segment follows
  std::uint8_t sequence = 0;  ///< 1 to 127; 0 is no segment

  /// The byte on the wire. \rtsafe
  [[nodiscard]] constexpr std::byte encode() const noexcept {
    return static_cast<std::byte>((last ? 0x80U : 0U) | (sequence & 0x7FU));
  }
  /// Every byte has a meaning. \rtsafe
  [[nodiscard]] static constexpr Segment decode(std::byte in) noexcept {
    const auto raw = std::to_integer<unsigned>(in);
    return {(raw & 0x80U) != 0, static_cast<std::uint8_t>(raw & 0x7FU)};
  }
  constexpr bool operator==(const Segment&) const = default;
};

/// CRC of the transferred data: polynomial x^16 + x^12 + x^5 + 1, initial value 0 (CiA 301 7.2.4.3.16). Continues at
/// `crc`. \rtsafe
[[nodiscard]] constexpr std::uint16_t crc16(std::span<const std::byte> data, std::uint16_t crc = 0) noexcept {
  for (const std::byte byte : data) {
    crc = static_cast<std::uint16_t>(crc ^ std::to_integer<unsigned>(byte) << 8U);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 0x8000U) != 0 ? 2U * crc ^ 0x1021U : 2U * crc);
    }
  }
  return crc;
}
}  // namespace sdo_block

}  // namespace driveline::canopen
