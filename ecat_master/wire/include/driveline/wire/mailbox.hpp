#pragma once

#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// Mailbox protocols (ETG.1000.4 Table 29, type field). Other values may arrive and are retained.
enum class MailboxType : std::uint8_t { kError = 0, kAoe = 1, kEoe = 2, kCoe = 3, kFoe = 4, kSoe = 5, kVoe = 15 };

/// Name of a protocol; "?" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(MailboxType type) noexcept {
  switch (type) {
    case MailboxType::kError:
      return "error";
    case MailboxType::kAoe:
      return "AoE";
    case MailboxType::kEoe:
      return "EoE";
    case MailboxType::kCoe:
      return "CoE";
    case MailboxType::kFoe:
      return "FoE";
    case MailboxType::kSoe:
      return "SoE";
    case MailboxType::kVoe:
      return "VoE";
  }
  return "?";
}

/// Mailbox header, 6 bytes at the start of every mailbox message (ETG.1000.4 5.6).
struct MailboxHeader {
  static constexpr std::size_t kSize = 6;  ///< size on the wire, in bytes
  std::uint16_t length = 0;                ///< bytes of service data behind the header
  std::uint16_t address = 0;               ///< station address of the source (to a slave) or destination
  std::uint8_t channel = 0;                ///< 0..63, reserved for future use
  std::uint8_t priority = 0;               ///< 0 lowest .. 3 highest
  MailboxType type = MailboxType::kError;  ///< protocol of the service data
  std::uint8_t counter = 0;                ///< 1..7 distinguishes a repeated message from a new one; 0: not counted

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), length);
    bytes::store_le(out.subspan<2, 2>(), address);
    bytes::store_le(out.subspan<4, 1>(), static_cast<std::uint8_t>((channel & 0x3FU) | (unsigned{priority} << 6)));
    bytes::store_le(out.subspan<5, 1>(),
                    static_cast<std::uint8_t>((static_cast<unsigned>(type) & 0x0FU) | ((counter & 7U) << 4)));
  }
  /// Checks that `length` bytes follow in `in`.
  [[nodiscard]] static constexpr Decoded<MailboxHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    MailboxHeader header;
    header.length = bytes::load_le<std::uint16_t>(in);
    header.address = bytes::load_le<std::uint16_t>(in.subspan(2));
    const auto channel_priority = bytes::load_le<std::uint8_t>(in.subspan(4));
    header.channel = channel_priority & 0x3FU;
    header.priority = static_cast<std::uint8_t>(channel_priority >> 6);
    const auto type_counter = bytes::load_le<std::uint8_t>(in.subspan(5));
    header.type = static_cast<MailboxType>(type_counter & 0x0FU);
    header.counter = (type_counter >> 4) & 7U;
    if (header.length > in.size() - kSize) return tl::unexpected(DecodeError::kBadLength);
    return header;
  }
  constexpr bool operator==(const MailboxHeader&) const = default;
};

/// The counter that follows `counter`: 1..7, never 0 (ETG.1000.4 5.6).
[[nodiscard]] constexpr std::uint8_t next_mailbox_counter(std::uint8_t counter) noexcept {
  return counter >= 7 ? std::uint8_t{1} : static_cast<std::uint8_t>(counter + 1);
}

/// Detail codes of a mailbox error reply (ETG.1000.4 Table 30).
enum class MailboxErrorCode : std::uint16_t {
  kSyntax = 1,
  kUnsupportedProtocol = 2,
  kInvalidChannel = 3,
  kServiceNotSupported = 4,
  kInvalidHeader = 5,
  kSizeTooShort = 6,
  kNoMoreMemory = 7,
  kInvalidSize = 8,
  kServiceInWork = 9,
};

/// Meaning of a code; "unknown mailbox error" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(MailboxErrorCode code) noexcept {
  switch (code) {
    case MailboxErrorCode::kSyntax:
      return "syntax of the mailbox header";
    case MailboxErrorCode::kUnsupportedProtocol:
      return "unsupported protocol";
    case MailboxErrorCode::kInvalidChannel:
      return "invalid channel";
    case MailboxErrorCode::kServiceNotSupported:
      return "service not supported";
    case MailboxErrorCode::kInvalidHeader:
      return "invalid header of the protocol";
    case MailboxErrorCode::kSizeTooShort:
      return "too short";
    case MailboxErrorCode::kNoMoreMemory:
      return "no more memory";
    case MailboxErrorCode::kInvalidSize:
      return "invalid size";
    case MailboxErrorCode::kServiceInWork:
      return "service in progress";
  }
  return "unknown mailbox error";
}

/// Service data of a mailbox error reply: type 0x0001 and the detail code.
struct MailboxErrorReply {
  static constexpr std::size_t kSize = 4;             ///< size on the wire, in bytes
  static constexpr std::uint16_t kErrorType = 1;      ///< value of the type field
  MailboxErrorCode code = MailboxErrorCode::kSyntax;  ///< why the slave rejected the message

  /// Writes the reply. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), kErrorType);
    bytes::store_le(out.subspan<2, 2>(), static_cast<std::uint16_t>(code));
  }
  /// Errors: kTooShort, kBadService for another error type. Unknown codes are retained. \rtsafe
  [[nodiscard]] static constexpr Decoded<MailboxErrorReply> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    if (bytes::load_le<std::uint16_t>(in) != kErrorType) return tl::unexpected(DecodeError::kBadService);
    return MailboxErrorReply{static_cast<MailboxErrorCode>(bytes::load_le<std::uint16_t>(in.subspan(2)))};
  }
  constexpr bool operator==(const MailboxErrorReply&) const = default;
};

}  // namespace driveline::wire
