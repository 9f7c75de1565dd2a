#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Error codes of the communication (CiA 301 Table 26).
namespace emergency_code {
inline constexpr std::uint16_t kNoError = 0x0000;              ///< the error, or the last of them, has gone
inline constexpr std::uint16_t kCanOverrun = 0x8110;           ///< frames were lost
inline constexpr std::uint16_t kErrorPassive = 0x8120;         ///< CAN controller in error passive mode
inline constexpr std::uint16_t kErrorControl = 0x8130;         ///< life guarding or heartbeat
inline constexpr std::uint16_t kRecoveredFromBusOff = 0x8140;  ///< CAN controller was bus off
inline constexpr std::uint16_t kPdoTooShort = 0x8210;          ///< PDO not processed because of its length
inline constexpr std::uint16_t kPdoTooLong = 0x8220;           ///< PDO has more bytes than mapped
}  // namespace emergency_code

/// Bits of the error register, object 1001h (CiA 301 7.5.2.2).
namespace error_register {
inline constexpr std::uint8_t kGeneric = 0x01;        ///< set while there is any error
inline constexpr std::uint8_t kCommunication = 0x10;  ///< error of the communication
}  // namespace error_register

/// EMCY message, 8 bytes (CiA 301 7.2.7).
struct Emergency {
  static constexpr std::size_t kSize = 8;   ///< size on the wire, in bytes
  std::uint16_t code = 0;                   ///< emergency error code; 0000h: no error
  std::uint8_t error_register = 0;          ///< object 1001h
  std::array<std::byte, 5> manufacturer{};  ///< manufacturer-specific

  /// The frame of this message. \rtsafe
  [[nodiscard]] constexpr Frame frame(Identifier identifier) const noexcept {
    std::array<std::byte, kSize> data{};
    bytes::store_le(data, code);
    data[2] = static_cast<std::byte>(error_register);
    std::copy(manufacturer.begin(), manufacturer.end(), data.begin() + 3);
    return Frame::of(identifier, data);
  }
  /// Empty unless the payload has eight bytes. \rtsafe
  [[nodiscard]] static constexpr std::optional<Emergency> decode(std::span<const std::byte> in) noexcept {
    if (in.size() != kSize) return std::nullopt;
    Emergency value{bytes::load_le<std::uint16_t>(in), std::to_integer<std::uint8_t>(in[2]), {}};
    std::copy_n(in.begin() + 3, value.manufacturer.size(), value.manufacturer.begin());
    return value;
  }
  constexpr bool operator==(const Emergency&) const = default;
};

}  // namespace driveline::canopen
