#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame.hpp"
#include "driveline/sdo/sdo_abort.hpp"

namespace driveline::canopen {

using sdo::SdoAbort;

/// Client command specifier, bits 5-7 of a request's first byte (CiA 301 7.2.4.3).
enum class SdoRequest : std::uint8_t {
  kDownloadSegment = 0,
  kInitiateDownload = 1,
  kInitiateUpload = 2,
  kUploadSegment = 3,
  kAbort = 4,
  kBlockUpload = 5,
  kBlockDownload = 6,
};

/// Server command specifier, bits 5-7 of an answer's first byte.
enum class SdoResponse : std::uint8_t {
  kUploadSegment = 0,
  kDownloadSegment = 1,
  kInitiateUpload = 2,
  kInitiateDownload = 3,
  kAbort = 4,
  kBlockDownload = 5,
  kBlockUpload = 6,
};

/// Eight bytes of an SDO that names an object: initiate and abort of every protocol (CiA 301 7.2.4.3).
struct SdoMessage {
  static constexpr std::size_t kSize = 8;  ///< size on the wire, in bytes
  std::uint8_t command = 0;                ///< specifier << 5 | flags
  std::uint16_t index = 0;                 ///< index of the object
  std::uint8_t subindex = 0;               ///< sub-index of the entry
  std::array<std::byte, 4> data{};         ///< value, size, or abort code

  static constexpr std::uint8_t kSizeIndicated =
      0x01;  ///< `data` holds the size; with kExpedited: bits 2-3 count unused bytes
  static constexpr std::uint8_t kExpedited = 0x02;  ///< `data` is the value

  /// Bits 5-7 of the command. \rtsafe
  [[nodiscard]] constexpr std::uint8_t specifier() const noexcept { return static_cast<std::uint8_t>(command >> 5); }
  /// Whether `data` is the value. \rtsafe
  [[nodiscard]] constexpr bool expedited() const noexcept { return (command & kExpedited) != 0; }
  /// Whether the size is stated. \rtsafe
  [[nodiscard]] constexpr bool size_indicated() const noexcept { return (command & kSizeIndicated) != 0; }
  /// Bytes of the value in an expedited transfer: 1 to 4; 4 when the size is not stated. \rtsafe
  [[nodiscard]] constexpr std::size_t expedited_size() const noexcept {
    return size_indicated() ? 4U - (command >> 2 & 3U) : 4U;
  }
  /// `data` as a number: size, or abort code. \rtsafe
  [[nodiscard]] constexpr std::uint32_t number() const noexcept { return bytes::load_le<std::uint32_t>(data); }

  /// The eight bytes. \rtsafe
  [[nodiscard]] constexpr std::array<std::byte, kSize> encode() const noexcept {
    std::array<std::byte, kSize> out{static_cast<std::byte>(command)};
    bytes::store_le(std::span(out).subspan(1), index);
    out[3] = static_cast<std::byte>(subindex);
    std::copy(data.begin(), data.end(), out.begin() + 4);
    return out;
  }
  /// Empty unless the payload has eight bytes. \rtsafe
  [[nodiscard]] static constexpr std::optional<SdoMessage> decode(std::span<const std::byte> in) noexcept {
    if (in.size() != kSize) return std::nullopt;
    return SdoMessage{std::to_integer<std::uint8_t>(in[0]),
                      bytes::load_le<std::uint16_t>(in.subspan(1)),
                      std::to_integer<std::uint8_t>(in[3]),
                      {in[4], in[5], in[6], in[7]}};
  }
  constexpr bool operator==(const SdoMessage&) const = default;
};

/// Command of an initiate message that carries `size` bytes, 1 to 4, with the size indicated. \rtsafe
template <typename Specifier>
[[nodiscard]] constexpr std::uint8_t expedited_command(Specifier specifier, std::size_t size) noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(specifier) << 5 | (4U - size) << 2 | SdoMessage::kExpedited |
                                   SdoMessage::kSizeIndicated);
}

/// Command without flags, or with those of the caller. \rtsafe
template <typename Specifier>
[[nodiscard]] constexpr std::uint8_t sdo_command(Specifier specifier, unsigned flags = 0) noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(specifier) << 5 | flags);
}

/// Abort message of either side (CiA 301 7.2.4.3.17). \rtsafe
[[nodiscard]] constexpr SdoMessage abort_message(std::uint16_t index, std::uint8_t subindex, SdoAbort code) noexcept {
  return {sdo_command(SdoRequest::kAbort), index, subindex, bytes::to_le_bytes(static_cast<std::uint32_t>(code))};
}

/// First byte of a segment and of its confirmation: specifier, toggle in bit 4, unused bytes in bits 1-3, "no more
/// segments" in bit 0 (CiA 301 7.2.4.3.4, .7).
struct SdoSegment {
  static constexpr std::size_t kData = 7;  ///< data bytes of a segment
  std::uint8_t specifier = 0;              ///< bits 5-7
  bool toggle = false;                     ///< alternates; false in the first segment
  std::uint8_t unused = 0;                 ///< bytes at the end that carry no data, 0 to 7
  bool last = false;                       ///< no segment follows

  /// The byte on the wire. \rtsafe
  [[nodiscard]] constexpr std::byte encode() const noexcept {
    return static_cast<std::byte>(specifier << 5 | (toggle ? 0x10 : 0) | unused << 1 | (last ? 1 : 0));
  }
  /// Every byte has a meaning. \rtsafe
  [[nodiscard]] static constexpr SdoSegment decode(std::byte in) noexcept {
    const auto raw = std::to_integer<unsigned>(in);
    return {static_cast<std::uint8_t>(raw >> 5), (raw & 0x10U) != 0, static_cast<std::uint8_t>(raw >> 1 & 7U),
            (raw & 1U) != 0};
  }
  constexpr bool operator==(const SdoSegment&) const = default;
};

}  // namespace driveline::canopen
