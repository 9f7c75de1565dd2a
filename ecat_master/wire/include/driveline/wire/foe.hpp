#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// Type of a FoE mailbox message (ETG.1000.6 5.8). Other values may arrive and are retained.
enum class FoeOpCode : std::uint8_t {
  kReadRequest = 1,   ///< password, then the file name
  kWriteRequest = 2,  ///< password, then the file name
  kData = 3,          ///< packet number from 1 on, then the data; the last packet is shorter than the mailbox allows
  kAck = 4,           ///< packet number; 0 answers a write request
  kError = 5,         ///< error code, then a text that may be empty
  kBusy = 6,          ///< progress of the other side, then a text that may be empty; the last message must be repeated
};

/// Header of every FoE mailbox message: op-code, a reserved byte, and four bytes whose meaning depends on the op-code.
struct FoeHeader {
  static constexpr std::size_t kSize = 6;       ///< size on the wire, in bytes
  FoeOpCode op_code = FoeOpCode::kReadRequest;  ///< type of the message
  std::uint32_t value = 0;                      ///< password, packet number, error code or FoeBusy

  /// Writes the header; the reserved byte is 0. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    out[0] = static_cast<std::byte>(op_code);
    out[1] = std::byte{0};
    bytes::store_le(out.subspan<2, 4>(), value);
  }
  /// Error: kTooShort. Unknown op-codes are retained. \rtsafe
  [[nodiscard]] static constexpr Decoded<FoeHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return FoeHeader{static_cast<FoeOpCode>(bytes::load_le<std::uint8_t>(in)),
                     bytes::load_le<std::uint32_t>(in.subspan(2))};
  }
  constexpr bool operator==(const FoeHeader&) const = default;
};

/// Value of a busy message: `done` of `entire`, in a unit chosen by the sender.
struct FoeBusy {
  std::uint16_t done = 0;    ///< progress so far
  std::uint16_t entire = 0;  ///< value at completion; 0: not known

  /// Encodes the fields as FoeHeader::value. \rtsafe
  [[nodiscard]] constexpr std::uint32_t value() const noexcept { return done | (std::uint32_t{entire} << 16); }
  /// Decodes FoeHeader::value. \rtsafe
  [[nodiscard]] static constexpr FoeBusy from_value(std::uint32_t value) noexcept {
    return {static_cast<std::uint16_t>(value & 0xFFFFU), static_cast<std::uint16_t>(value >> 16)};
  }
  constexpr bool operator==(const FoeBusy&) const = default;
};

/// FoE error codes (ETG.1000.6 Table 92). Other values may arrive and are retained.
enum class FoeError : std::uint32_t {
  kNotDefined = 0x8000,
  kNotFound = 0x8001,
  kAccessDenied = 0x8002,
  kDiskFull = 0x8003,
  kIllegal = 0x8004,
  kPacketNumber = 0x8005,
  kAlreadyExists = 0x8006,
  kNoUser = 0x8007,
  kBootstrapOnly = 0x8008,
  kNotBootstrap = 0x8009,
  kNoRights = 0x800A,
  kProgramError = 0x800B,
  kWrongChecksum = 0x800C,
  kWrongFirmware = 0x800D,
  kNoFile = 0x800F,
  kNoFileHeader = 0x8010,
  kFlash = 0x8011,
  kIncompatible = 0x8012,
};

/// A code and its text.
struct FoeErrorText {
  FoeError code;          ///< the code
  std::string_view text;  ///< its meaning
};

/// Every code of the standard with its meaning.
inline constexpr std::array kFoeErrorTexts = {
    FoeErrorText{FoeError::kNotDefined, "not defined"},
    FoeErrorText{FoeError::kNotFound, "not found"},
    FoeErrorText{FoeError::kAccessDenied, "access denied"},
    FoeErrorText{FoeError::kDiskFull, "disk full"},
    FoeErrorText{FoeError::kIllegal, "illegal"},
    FoeErrorText{FoeError::kPacketNumber, "packet number wrong"},
    FoeErrorText{FoeError::kAlreadyExists, "already exists"},
    FoeErrorText{FoeError::kNoUser, "no user"},
    FoeErrorText{FoeError::kBootstrapOnly, "in bootstrap only"},
    FoeErrorText{FoeError::kNotBootstrap, "not in bootstrap"},
    FoeErrorText{FoeError::kNoRights, "no rights"},
    FoeErrorText{FoeError::kProgramError, "program error"},
    FoeErrorText{FoeError::kWrongChecksum, "checksum wrong"},
    FoeErrorText{FoeError::kWrongFirmware, "firmware does not fit the hardware"},
    FoeErrorText{FoeError::kNoFile, "no file to read"},
    FoeErrorText{FoeError::kNoFileHeader, "the file has no header"},
    FoeErrorText{FoeError::kFlash, "flash problem"},
    FoeErrorText{FoeError::kIncompatible, "file incompatible"},
};

/// Meaning of a code; "unknown FoE error" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(FoeError code) noexcept {
  for (const auto& row : kFoeErrorTexts) {
    if (row.code == code) return row.text;
  }
  return "unknown FoE error";
}

}  // namespace driveline::wire
