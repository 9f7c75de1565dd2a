#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// Type of a SoE mailbox message (ETG.1000.6 5.9). Other values may arrive and are retained.
enum class SoeOpCode : std::uint8_t {
  kReadRequest = 1,    ///< no data behind the header
  kReadResponse = 2,   ///< the requested elements in bit order, or an error
  kWriteRequest = 3,   ///< one element
  kWriteResponse = 4,  ///< no data, or an error
  kNotification = 5,   ///< new data state of a procedure command
  kEmergency = 6,      ///< emergency message, as in CoE
};

/// Elements of an operation datum; each is one bit in the header (IEC 61800-7-204, elements 1 to 7).
enum class SoeElement : std::uint8_t {
  kState = 0x01,      ///< data state, 16 bits; for procedure commands SoeCommandState
  kName = 0x02,       ///< name, a list of characters
  kAttribute = 0x04,  ///< SoeAttribute
  kUnit = 0x08,       ///< unit, a list of characters
  kMin = 0x10,        ///< minimum, as long as the value
  kMax = 0x20,        ///< maximum, as long as the value
  kValue = 0x40,      ///< 1, 2, 4, 8 bytes or a list, as the attribute says
  kDefault = 0x80,    ///< default value, as long as the value
};

/// Every element, in the order in which a message carries them.
inline constexpr std::array kSoeElements = {SoeElement::kState, SoeElement::kName,   SoeElement::kAttribute,
                                            SoeElement::kUnit,  SoeElement::kMin,    SoeElement::kMax,
                                            SoeElement::kValue, SoeElement::kDefault};

/// A set of elements of an operation datum.
struct SoeElementSet {
  std::uint8_t bits = 0;  ///< bitwise OR of SoeElement

  constexpr SoeElementSet() = default;
  /// A set with one element.
  constexpr SoeElementSet(SoeElement element) noexcept  // NOLINT(google-explicit-constructor): an element is a set
      : bits(static_cast<std::uint8_t>(element)) {}
  /// The set in the element byte of a header.
  [[nodiscard]] static constexpr SoeElementSet of(std::uint8_t bits) noexcept {
    SoeElementSet set;
    set.bits = bits;
    return set;
  }
  /// Whether the element is in the set. \rtsafe
  [[nodiscard]] constexpr bool has(SoeElement element) const noexcept {
    return (bits & static_cast<std::uint8_t>(element)) != 0;
  }
  /// Number of elements. \rtsafe
  [[nodiscard]] constexpr int count() const noexcept { return std::popcount(bits); }
  constexpr bool operator==(const SoeElementSet&) const = default;
};

/// Union of two sets.
[[nodiscard]] constexpr SoeElementSet operator|(SoeElementSet a, SoeElementSet b) noexcept {
  return SoeElementSet::of(static_cast<std::uint8_t>(a.bits | b.bits));
}

/// A set with two elements.
[[nodiscard]] constexpr SoeElementSet operator|(SoeElement a, SoeElement b) noexcept {
  return SoeElementSet(a) | SoeElementSet(b);
}

/// Number of an operation datum (IDN): "S-0-0017" from the standard, "P-0-0017" from the product; the middle digit is
/// the parameter set.
struct Idn {
  std::uint16_t raw = 0;  ///< bit 15: P; bits 12 to 14: parameter set; bits 0 to 11: number

  /// "S-0-0017", 8 characters. \rtsafe
  [[nodiscard]] constexpr std::array<char, 8> text() const noexcept {
    const unsigned number = raw & 0x0FFFU;
    const auto digit = [](unsigned value) { return static_cast<char>('0' + value % 10); };
    return {(raw & 0x8000U) != 0 ? 'P' : 'S',
            '-',
            digit((raw >> 12) & 7U),
            '-',
            digit(number / 1000),
            digit(number / 100),
            digit(number / 10),
            digit(number)};
  }
  /// Parses "S-0-0017" or "s-0-17"; empty when the text is not an IDN. \rtsafe
  [[nodiscard]] static constexpr std::optional<Idn> from_text(std::string_view text) noexcept {
    const bool shaped = text.size() >= 5 && text.size() <= 8 && text[1] == '-' && text[3] == '-';
    if (!shaped || text[2] < '0' || text[2] > '7') return std::nullopt;
    const bool of_product = text[0] == 'P' || text[0] == 'p';
    if (!of_product && text[0] != 'S' && text[0] != 's') return std::nullopt;
    unsigned number = 0;
    for (const char c : text.substr(4)) {
      if (c < '0' || c > '9') return std::nullopt;
      number = 10 * number + static_cast<unsigned>(c - '0');
    }
    if (number > 0x0FFF) return std::nullopt;
    const auto set = static_cast<unsigned>(text[2] - '0');
    return Idn{static_cast<std::uint16_t>((of_product ? 0x8000U : 0U) | set << 12 | number)};
  }
  constexpr bool operator==(const Idn&) const = default;
};

/// Header of every SoE mailbox message.
struct SoeHeader {
  static constexpr std::size_t kSize = 4;       ///< size on the wire, in bytes
  SoeOpCode op_code = SoeOpCode::kReadRequest;  ///< 3 bits
  bool incomplete = false;                      ///< more fragments follow
  bool error = false;                           ///< a SoeError follows
  std::uint8_t drive = 0;                       ///< drive of the slave, 0 to 7
  SoeElementSet elements;                       ///< elements that the message carries or requests
  std::uint16_t value = 0;  ///< the Idn; in an incomplete message: number of fragments still to come

  /// The operation datum; meaningless in an incomplete message. \rtsafe
  [[nodiscard]] constexpr Idn idn() const noexcept { return {value}; }
  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    out[0] = static_cast<std::byte>((static_cast<unsigned>(op_code) & 7U) | (incomplete ? 0x08U : 0U) |
                                    (error ? 0x10U : 0U) | (drive & 7U) << 5);
    out[1] = static_cast<std::byte>(elements.bits);
    bytes::store_le(out.subspan<2, 2>(), value);
  }
  /// Error: kTooShort. Unknown op-codes are retained. \rtsafe
  [[nodiscard]] static constexpr Decoded<SoeHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto first = bytes::load_le<std::uint8_t>(in);
    return SoeHeader{static_cast<SoeOpCode>(first & 7U),
                     (first & 0x08U) != 0,
                     (first & 0x10U) != 0,
                     static_cast<std::uint8_t>(first >> 5),
                     SoeElementSet::of(bytes::load_le<std::uint8_t>(in.subspan(1))),
                     bytes::load_le<std::uint16_t>(in.subspan(2))};
  }
  constexpr bool operator==(const SoeHeader&) const = default;
};

/// Header of a list; names and units are lists, too.
struct SoeListHeader {
  static constexpr std::size_t kSize = 4;  ///< size on the wire, in bytes
  std::uint16_t length = 0;                ///< current length of the list, in bytes
  std::uint16_t capacity = 0;              ///< maximum length of the list, in bytes

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), length);
    bytes::store_le(out.subspan<2, 2>(), capacity);
  }
  /// Error: kTooShort. Whether `length` bytes follow is not checked. \rtsafe
  [[nodiscard]] static constexpr Decoded<SoeListHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return SoeListHeader{bytes::load_le<std::uint16_t>(in), bytes::load_le<std::uint16_t>(in.subspan(2))};
  }
  constexpr bool operator==(const SoeListHeader&) const = default;
};

/// Display format of a value.
enum class SoeDisplay : std::uint8_t {
  kBinary = 0,
  kUnsigned = 1,
  kSigned = 2,
  kHexadecimal = 3,
  kText = 4,
  kIdn = 5,
  kFloat = 6,
  kReserved = 7,
};

/// Attribute of an operation datum (IEC 61800-7-204, element 3).
struct SoeAttribute {
  static constexpr std::size_t kSize = 4;  ///< size on the wire, in bytes
  std::uint16_t conversion_factor = 1;     ///< conversion factor of the displayed value
  std::uint8_t length_code = 1;            ///< 0 to 3: size of the value, or of each list element, is 1, 2, 4, 8 bytes
  bool list = false;                       ///< the value is a list of variable length
  bool command = false;                    ///< a procedure command
  SoeDisplay display = SoeDisplay::kUnsigned;  ///< 3 bits
  std::uint8_t decimals = 0;                   ///< 0 to 15: decimal places of the displayed value
  bool pre_op_protected = false;               ///< cannot be written in PREOP (phase 2)
  bool safe_op_protected = false;              ///< cannot be written in SAFEOP (phase 3)
  bool op_protected = false;                   ///< cannot be written in OP (phase 4)

  /// Bytes of the value, or of each element of a list. \rtsafe
  [[nodiscard]] constexpr std::size_t element_size() const noexcept { return std::size_t{1} << (length_code & 3U); }
  /// Writes the attribute; reserved bits are 0. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    const std::uint32_t bits = conversion_factor | (length_code & 3U) << 16 | (list ? 1U << 18 : 0U) |
                               (command ? 1U << 19 : 0U) | (static_cast<unsigned>(display) & 7U) << 20 |
                               (decimals & 15U) << 24 | (pre_op_protected ? 1U << 28 : 0U) |
                               (safe_op_protected ? 1U << 29 : 0U) | (op_protected ? 1U << 30 : 0U);
    bytes::store_le(out, bits);
  }
  /// Error: kTooShort. Reserved bits are ignored. \rtsafe
  [[nodiscard]] static constexpr Decoded<SoeAttribute> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto bits = bytes::load_le<std::uint32_t>(in);
    const auto bit = [bits](unsigned number) { return (bits >> number & 1U) != 0; };
    return SoeAttribute{static_cast<std::uint16_t>(bits & 0xFFFFU),
                        static_cast<std::uint8_t>(bits >> 16 & 3U),
                        bit(18),
                        bit(19),
                        static_cast<SoeDisplay>(bits >> 20 & 7U),
                        static_cast<std::uint8_t>(bits >> 24 & 15U),
                        bit(28),
                        bit(29),
                        bit(30)};
  }
  constexpr bool operator==(const SoeAttribute&) const = default;
};

/// Data state of a procedure command. Other values may arrive and are retained.
enum class SoeCommandState : std::uint16_t {
  kNotSet = 0,
  kSet = 1,
  kExecuted = 3,
  kInterrupted = 5,
  kInProgress = 7,
  kFailed = 15,
};

/// Meaning of a data state; "unknown" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(SoeCommandState state) noexcept {
  switch (state) {
    case SoeCommandState::kNotSet:
      return "not set";
    case SoeCommandState::kSet:
      return "set";
    case SoeCommandState::kExecuted:
      return "executed";
    case SoeCommandState::kInterrupted:
      return "interrupted";
    case SoeCommandState::kInProgress:
      return "in progress";
    case SoeCommandState::kFailed:
      return "failed";
  }
  return "unknown";
}

/// Starts a procedure command when written to it: set and enabled.
inline constexpr std::uint16_t kSoeCommandStart = 3;
/// Cancels a procedure command when written to it, also after it has ended.
inline constexpr std::uint16_t kSoeCommandCancel = 0;

/// SoE error codes (IEC 61800-7-204: the first digit is the element, 8 for none). Other values may arrive and are
/// retained.
enum class SoeError : std::uint16_t {
  kNoIdn = 0x1001,
  kWrongAccess = 0x1009,
  kNoName = 0x2001,
  kNameTooShort = 0x2002,
  kNameTooLong = 0x2003,
  kNameReadOnly = 0x2004,
  kNameProtected = 0x2005,
  kAttributeTooShort = 0x3002,
  kAttributeTooLong = 0x3003,
  kAttributeReadOnly = 0x3004,
  kAttributeProtected = 0x3005,
  kNoUnit = 0x4001,
  kUnitTooShort = 0x4002,
  kUnitTooLong = 0x4003,
  kUnitReadOnly = 0x4004,
  kUnitProtected = 0x4005,
  kNoMin = 0x5001,
  kMinTooShort = 0x5002,
  kMinTooLong = 0x5003,
  kMinReadOnly = 0x5004,
  kMinProtected = 0x5005,
  kNoMax = 0x6001,
  kMaxTooShort = 0x6002,
  kMaxTooLong = 0x6003,
  kMaxReadOnly = 0x6004,
  kMaxProtected = 0x6005,
  kValueTooShort = 0x7002,
  kValueTooLong = 0x7003,
  kValueReadOnly = 0x7004,
  kValueProtected = 0x7005,
  kValueTooSmall = 0x7006,
  kValueTooLarge = 0x7007,
  kValueInvalid = 0x7008,
  kPassword = 0x7009,
  kCyclic = 0x700A,
  kIndirect = 0x700B,
  kOtherSettings = 0x700C,
  kReserved = 0x700D,
  kCommandActive = 0x7010,
  kNotInterruptible = 0x7011,
  kNotNow = 0x7012,
  kNotExecutable = 0x7013,
  kNoState = 0x7014,
  kNoDefault = 0x8001,
  kDefaultTooLong = 0x8002,
  kDefaultReadOnly = 0x8004,
  kNoDrive = 0x800A,
  kGeneral = 0x800B,
  kNoElement = 0x800C,
};

/// A code and its text.
struct SoeErrorText {
  SoeError code;          ///< the code
  std::string_view text;  ///< its meaning
};

/// Every code of the standard with its meaning.
inline constexpr std::array kSoeErrorTexts = {
    SoeErrorText{SoeError::kNoIdn, "there is no such IDN"},
    SoeErrorText{SoeError::kWrongAccess, "wrong access to the IDN"},
    SoeErrorText{SoeError::kNoName, "it has no name"},
    SoeErrorText{SoeError::kNameTooShort, "name too short"},
    SoeErrorText{SoeError::kNameTooLong, "name too long"},
    SoeErrorText{SoeError::kNameReadOnly, "the name cannot be changed"},
    SoeErrorText{SoeError::kNameProtected, "the name cannot be changed now"},
    SoeErrorText{SoeError::kAttributeTooShort, "attribute too short"},
    SoeErrorText{SoeError::kAttributeTooLong, "attribute too long"},
    SoeErrorText{SoeError::kAttributeReadOnly, "the attribute cannot be changed"},
    SoeErrorText{SoeError::kAttributeProtected, "the attribute cannot be changed now"},
    SoeErrorText{SoeError::kNoUnit, "it has no unit"},
    SoeErrorText{SoeError::kUnitTooShort, "unit too short"},
    SoeErrorText{SoeError::kUnitTooLong, "unit too long"},
    SoeErrorText{SoeError::kUnitReadOnly, "the unit cannot be changed"},
    SoeErrorText{SoeError::kUnitProtected, "the unit cannot be changed now"},
    SoeErrorText{SoeError::kNoMin, "it has no minimum"},
    SoeErrorText{SoeError::kMinTooShort, "minimum too short"},
    SoeErrorText{SoeError::kMinTooLong, "minimum too long"},
    SoeErrorText{SoeError::kMinReadOnly, "the minimum cannot be changed"},
    SoeErrorText{SoeError::kMinProtected, "the minimum cannot be changed now"},
    SoeErrorText{SoeError::kNoMax, "it has no maximum"},
    SoeErrorText{SoeError::kMaxTooShort, "maximum too short"},
    SoeErrorText{SoeError::kMaxTooLong, "maximum too long"},
    SoeErrorText{SoeError::kMaxReadOnly, "the maximum cannot be changed"},
    SoeErrorText{SoeError::kMaxProtected, "the maximum cannot be changed now"},
    SoeErrorText{SoeError::kValueTooShort, "value too short"},
    SoeErrorText{SoeError::kValueTooLong, "value too long"},
    SoeErrorText{SoeError::kValueReadOnly, "the value cannot be changed"},
    SoeErrorText{SoeError::kValueProtected, "the value cannot be changed in this state"},
    SoeErrorText{SoeError::kValueTooSmall, "value below its minimum"},
    SoeErrorText{SoeError::kValueTooLarge, "value above its maximum"},
    SoeErrorText{SoeError::kValueInvalid, "value not valid"},
    SoeErrorText{SoeError::kPassword, "protected by a password"},
    SoeErrorText{SoeError::kCyclic, "the value is configured cyclically"},
    SoeErrorText{SoeError::kIndirect, "indirect addressing not valid"},
    SoeErrorText{SoeError::kOtherSettings, "protected by other settings"},
    SoeErrorText{SoeError::kReserved, "reserved"},
    SoeErrorText{SoeError::kCommandActive, "the command is active already"},
    SoeErrorText{SoeError::kNotInterruptible, "the command cannot be interrupted"},
    SoeErrorText{SoeError::kNotNow, "the command cannot be executed now"},
    SoeErrorText{SoeError::kNotExecutable, "the command cannot be executed, parameters are wrong"},
    SoeErrorText{SoeError::kNoState, "it has no data state"},
    SoeErrorText{SoeError::kNoDefault, "it has no default value"},
    SoeErrorText{SoeError::kDefaultTooLong, "default value too long"},
    SoeErrorText{SoeError::kDefaultReadOnly, "the default value cannot be changed"},
    SoeErrorText{SoeError::kNoDrive, "there is no such drive"},
    SoeErrorText{SoeError::kGeneral, "general error"},
    SoeErrorText{SoeError::kNoElement, "no element is addressed"},
};

/// Meaning of a code; "unknown SoE error" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(SoeError code) noexcept {
  for (const auto& row : kSoeErrorTexts) {
    if (row.code == code) return row.text;
  }
  return "unknown SoE error";
}

}  // namespace driveline::wire
