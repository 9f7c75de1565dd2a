#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// SYNC message (CiA 301 7.2.5): without data, or with a counter.
struct Sync {
  std::uint8_t counter = 0;  ///< 1 to the overflow value; 0: the message has no counter

  /// The frame of this message. \rtsafe
  [[nodiscard]] constexpr Frame frame(Identifier identifier) const noexcept {
    const std::array data{static_cast<std::byte>(counter)};
    return Frame::of(identifier, std::span(data).first(counter == 0 ? 0 : 1));
  }
  /// Empty unless the payload has no byte or one. \rtsafe
  [[nodiscard]] static constexpr std::optional<Sync> decode(std::span<const std::byte> in) noexcept {
    if (in.size() > 1) return std::nullopt;
    return Sync{in.empty() ? std::uint8_t{0} : std::to_integer<std::uint8_t>(in[0])};
  }
  constexpr bool operator==(const Sync&) const = default;
};

/// TIME message: TIME_OF_DAY, 6 bytes (CiA 301 7.2.6 and 7.1.6.5).
struct TimeOfDay {
  static constexpr std::size_t kSize = 6;  ///< size on the wire, in bytes
  std::uint32_t milliseconds = 0;          ///< since midnight, 28 bits
  std::uint16_t days = 0;                  ///< since 1 January 1984

  /// The frame of this message; the four reserved bits are 0. \rtsafe
  [[nodiscard]] constexpr Frame frame(Identifier identifier) const noexcept {
    std::array<std::byte, kSize> data{};
    bytes::store_le(data, milliseconds & 0x0FFF'FFFFU);
    bytes::store_le(std::span(data).subspan(4), days);
    return Frame::of(identifier, data);
  }
  /// Empty unless the payload has six bytes. \rtsafe
  [[nodiscard]] static constexpr std::optional<TimeOfDay> decode(std::span<const std::byte> in) noexcept {
    if (in.size() != kSize) return std::nullopt;
    return TimeOfDay{bytes::load_le<std::uint32_t>(in) & 0x0FFF'FFFFU, bytes::load_le<std::uint16_t>(in.subspan(4))};
  }
  constexpr bool operator==(const TimeOfDay&) const = default;
};

}  // namespace driveline::canopen
