#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "driveline/esi/data_type.hpp"

/// Row of a device's object dictionary table: all properties of a sub-index.
namespace driveline::slaves {

/// Communication phases; the front end of a bus maps its states to them.
enum class AccessPhase : std::uint8_t {
  kClosed,       ///< no access
  kConfiguring,  ///< process data are being configured
  kReady,        ///< the device's process data are valid, those of the bus are not yet
  kOperating,    ///< the process data of both device and bus are valid
};

/// Access bits of a row, and the combinations that tables use.
namespace access {
inline constexpr std::uint16_t kReadConfiguring = 0x0001;   ///< readable in this phase
inline constexpr std::uint16_t kReadReady = 0x0002;         ///< readable in this phase
inline constexpr std::uint16_t kReadOperating = 0x0004;     ///< readable in this phase
inline constexpr std::uint16_t kWriteConfiguring = 0x0008;  ///< writable in this phase
inline constexpr std::uint16_t kWriteReady = 0x0010;        ///< writable in this phase
inline constexpr std::uint16_t kWriteOperating = 0x0020;    ///< writable in this phase
inline constexpr std::uint16_t kRxMappable = 0x0040;  ///< can be mapped into process data that the device receives
inline constexpr std::uint16_t kTxMappable = 0x0080;  ///< can be mapped into process data that the device sends
inline constexpr std::uint16_t kBackup = 0x0100;      ///< stored by "store parameters"
inline constexpr std::uint16_t kRead = kReadConfiguring | kReadReady | kReadOperating;      ///< in every open phase
inline constexpr std::uint16_t kWrite = kWriteConfiguring | kWriteReady | kWriteOperating;  ///< in every open phase
inline constexpr std::uint16_t kReadWrite = kRead | kWrite;                                 ///< in every open phase
inline constexpr std::uint16_t kReadWriteConfiguring = kRead | kWriteConfiguring;           ///< process data settings
}  // namespace access

/// Storage of a row's value. Rows with the same slot number are aliases: one value with several addresses.
namespace slot {
inline constexpr std::uint16_t kOwn = 0xFFFF;       ///< the table assigns a separate slot to the row
inline constexpr std::uint16_t kConstant = 0xFFFE;  ///< never changes: `initial` of the row
}  // namespace slot

/// Row of an object dictionary table. Numbers of up to 53 bits and REAL32 values are exact in a double.
struct EntryRow {
  std::uint16_t index = 0;                            ///< index of the object
  std::uint8_t subindex = 0;                          ///< 0 for the value of a VAR
  esi::ObjectCode code = esi::ObjectCode::kVariable;  ///< code of the whole object, the same in all its rows
  esi::DataType type = esi::DataType::kUnsigned32;    ///< data type of this sub-index
  /// access rights: bits of namespace access
  std::uint16_t access = access::kRead;
  std::uint16_t slot = slot::kOwn;  ///< slot number of the value, see namespace slot
  std::string_view name{};          ///< name of the object in its first row, of the sub-index in the other rows
  double initial = 0.0;             ///< value after power-on when no value is stored; rows stored as bytes use `text`
  double minimum = -std::numeric_limits<double>::infinity();  ///< infinite: the limit of the data type
  double maximum = std::numeric_limits<double>::infinity();   ///< infinite: the limit of the data type
  std::string_view unit{};  ///< text for display, reported by SDO information; empty: none
  /// Initial value of a row stored as bytes, or of a 64-bit number that is not exact in a double (its eight bytes).
  std::string_view text{};
  std::uint16_t string_length = 0;  ///< rows stored as bytes: declared length; shorter contents are padded with zeros
  std::uint16_t record_type = 0;    ///< data type index of a RECORD (ETG.1000.6 Table 64), first row
  bool power_off_only = false;      ///< can be written only while the power stage is off
  std::string_view source{};        ///< source of the facts; "ours" marks facts that no source states
  std::uint16_t bit_length = 0;     ///< 0: length of the data type
  std::uint32_t bit_offset = kBehindPrevious;  ///< in complete access; sub-index 0 is at bit 0, the next entry at 16

  /// The entry starts where the previous one ends.
  static constexpr std::uint32_t kBehindPrevious = 0xFFFFFFFF;
};

/// Whether `type` is one of INTEGER8 to INTEGER64; false for REAL types. \rtsafe
[[nodiscard]] constexpr bool is_signed(esi::DataType type) noexcept {
  return type == esi::DataType::kInteger8 || type == esi::DataType::kInteger16 || type == esi::DataType::kInteger32 ||
         type == esi::DataType::kInteger64;
}

/// Returns the number of bits of BIT1 to BIT8; 0 for other types.
[[nodiscard]] constexpr std::uint8_t bit_field_size(esi::DataType type) noexcept {
  const auto first = static_cast<unsigned>(esi::DataType::kBit1);
  const auto last = static_cast<unsigned>(esi::DataType::kBit8);
  const auto code = static_cast<unsigned>(type);
  return code >= first && code <= last ? static_cast<std::uint8_t>(code - first + 1) : std::uint8_t{0};
}

/// Returns the size in bytes of a number of `type` in an SDO; 0 for strings and other types that are stored as bytes.
[[nodiscard]] constexpr std::size_t byte_size(esi::DataType type) noexcept {
  switch (type) {
    case esi::DataType::kBoolean:
    case esi::DataType::kInteger8:
    case esi::DataType::kUnsigned8:
      return 1;
    case esi::DataType::kInteger16:
    case esi::DataType::kUnsigned16:
      return 2;
    case esi::DataType::kInteger32:
    case esi::DataType::kUnsigned32:
    case esi::DataType::kReal32:
      return 4;
    case esi::DataType::kInteger64:
    case esi::DataType::kUnsigned64:
    case esi::DataType::kReal64:
      return 8;
    default:
      return bit_field_size(type) != 0 ? 1 : 0;
  }
}

/// Whether values of `type` are stored as bytes, not as a number.
[[nodiscard]] constexpr bool is_string(esi::DataType type) noexcept {
  return byte_size(type) == 0;
}

/// Returns the size in bytes of the row in an SDO; its declared length when it is stored as bytes. \rtsafe
[[nodiscard]] constexpr std::size_t byte_size(const EntryRow& row) noexcept {
  return is_string(row.type) ? row.string_length : byte_size(row.type);
}

/// Returns the bits of the row in process data and complete access. A BOOLEAN has one (ETG.1020, base data types).
[[nodiscard]] constexpr std::size_t bit_size(const EntryRow& row) noexcept {
  if (row.bit_length != 0) return row.bit_length;
  if (row.type == esi::DataType::kBoolean) return 1;
  const std::size_t field = bit_field_size(row.type);
  return field != 0 ? field : 8 * byte_size(row);
}

/// Returns `number` as raw 64 bits of `type`: two's complement, sign extended, or the IEEE 754 bits of a REAL.
[[nodiscard]] std::uint64_t raw_from_number(esi::DataType type, double number) noexcept;
/// Returns the number that a raw value represents.
[[nodiscard]] double number_from_raw(esi::DataType type, std::uint64_t raw) noexcept;
/// Returns the initial raw value of a numeric row.
[[nodiscard]] std::uint64_t initial_raw(const EntryRow& row) noexcept;

/// Returns the name of the sub-index: entry 0 of arrays and records of the standard is their length, while manufacturer
/// parameters have data at sub-index 0.
[[nodiscard]] constexpr std::string_view entry_name(const EntryRow& row) noexcept {
  const bool standard = row.index < 0x2000 || row.index >= 0x6000;
  const bool length = standard && row.subindex == 0 && row.code != esi::ObjectCode::kVariable;
  return length ? std::string_view{"Number of entries"} : row.name;
}

}  // namespace driveline::slaves
