#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// CAN frames and the protocols of CANopen on them, as declarations and a codec.
namespace driveline::canopen {

/// CAN identifier with 11 bits (base format) or 29 bits (extended format), ISO 11898-1.
struct Identifier {
  static constexpr std::uint32_t kBaseMask = 0x7FF;            ///< bits of a base identifier
  static constexpr std::uint32_t kExtendedMask = 0x1FFF'FFFF;  ///< bits of an extended identifier

  std::uint32_t value = 0;  ///< 0 to 7FFh, or to 1FFFFFFFh when `extended`
  bool extended = false;    ///< the same value in the other format is another identifier

  /// Whether the value has no more bits than its format. \rtsafe
  [[nodiscard]] constexpr bool valid() const noexcept { return value <= (extended ? kExtendedMask : kBaseMask); }
  constexpr bool operator==(const Identifier&) const = default;
};

/// Kind of a frame.
enum class FrameKind : std::uint8_t {
  kData,    ///< carries up to 8 bytes
  kRemote,  ///< asks for the data frame of the same identifier; `length` is that of the answer
  kError,   ///< an error flag on the bus, as listeners report it; has neither identifier nor data
};

/// CAN frame of the classic format. Plain value; bytes behind `length` are zero.
struct Frame {
  static constexpr std::size_t kMaxLength = 8;  ///< most data bytes of a frame

  Identifier identifier;                     ///< which message this is, and its priority
  FrameKind kind = FrameKind::kData;         ///< data, remote or error frame
  std::uint8_t length = 0;                   ///< data length code, 0 to 8
  std::array<std::byte, kMaxLength> data{};  ///< see payload()

  /// Data frame with a base identifier. Bytes beyond the eighth are ignored. \rtsafe
  [[nodiscard]] static constexpr Frame of(std::uint32_t base_identifier, std::span<const std::byte> payload) noexcept {
    return of(Identifier{base_identifier, false}, payload);
  }
  /// Data frame. Bytes beyond the eighth are ignored. \rtsafe
  [[nodiscard]] static constexpr Frame of(Identifier identifier, std::span<const std::byte> payload) noexcept {
    Frame frame{identifier};
    frame.length = static_cast<std::uint8_t>(std::min(payload.size(), kMaxLength));
    std::copy_n(payload.begin(), frame.length, frame.data.begin());
    return frame;
  }
  /// Remote frame that asks for `length` bytes, 0 to 8. \rtsafe
  [[nodiscard]] static constexpr Frame remote(Identifier identifier, std::uint8_t length) noexcept {
    return {identifier, FrameKind::kRemote, length, {}};
  }
  /// Whether identifier and length are possible on a bus. \rtsafe
  [[nodiscard]] constexpr bool valid() const noexcept {
    return kind != FrameKind::kError && identifier.valid() && length <= kMaxLength;
  }
  /// The data bytes; none of a remote frame. \rtsafe
  [[nodiscard]] constexpr std::span<const std::byte> payload() const noexcept {
    return std::span(data).first(kind == FrameKind::kData ? std::min<std::size_t>(length, kMaxLength) : 0);
  }
  constexpr bool operator==(const Frame&) const = default;
};

/// The arbitration field as a number: of two frames the one with the lower number wins the bus. A dominant bit is 0, so
/// a base frame is before an extended one with the same first 11 bits, and a data frame before the remote frame of the
/// same identifier (ISO 11898-1, 10.4.2: ID-28 to ID-18, RTR or SRR, IDE, ID-17 to ID-0, RTR). \rtsafe
[[nodiscard]] constexpr std::uint32_t arbitration_field(const Frame& frame) noexcept {
  const std::uint32_t remote = frame.kind == FrameKind::kRemote ? 1 : 0;
  const std::uint32_t value = frame.identifier.value;
  if (!frame.identifier.extended) return value << 21 | remote << 20;
  constexpr std::uint32_t kSubstituteRemoteRequest = 1U << 20;
  constexpr std::uint32_t kIdentifierExtension = 1U << 19;
  return value >> 18 << 21 | kSubstituteRemoteRequest | kIdentifierExtension | (value & 0x3'FFFF) << 1 | remote;
}

}  // namespace driveline::canopen
