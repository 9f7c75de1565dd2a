#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "driveline/esi/data_type.hpp"

/// One row of a device's object dictionary table: everything that is known about one sub-index, in one place.
namespace driveline::slaves {

/// Phases of communication, to which the front end of a bus maps its states.
enum class AccessPhase : std::uint8_t {
  kClosed,       ///< nothing is read or written
  kConfiguring,  ///< process data are being set up
  kReady,        ///< the device's process data are valid, those of the bus not yet
  kOperating,    ///< both are
};

/// Access bits of a row, and the combinations that tables use.
namespace access {
inline constexpr std::uint16_t kReadConfiguring = 0x0001;   ///< readable in this phase
inline constexpr std::uint16_t kReadReady = 0x0002;         ///< readable in this phase
inline constexpr std::uint16_t kReadOperating = 0x0004;     ///< readable in this phase
inline constexpr std::uint16_t kWriteConfiguring = 0x0008;  ///< writable in this phase
inline constexpr std::uint16_t kWriteReady = 0x0010;        ///< writable in this phase
inline constexpr std::uint16_t kWriteOperating = 0x0020;    ///< writable in this phase
inline constexpr std::uint16_t kRxMappable = 0x0040;        ///< can be mapped into process data the device receives
inline constexpr std::uint16_t kTxMappable = 0x0080;        ///< can be mapped into process data the device sends
inline constexpr std::uint16_t kBackup = 0x0100;            ///< kept by "store parameters"
inline constexpr std::uint16_t kRead = kReadConfiguring | kReadReady | kReadOperating;      ///< in every open phase
inline constexpr std::uint16_t kWrite = kWriteConfiguring | kWriteReady | kWriteOperating;  ///< in every open phase
inline constexpr std::uint16_t kReadWrite = kRead | kWrite;                                 ///< in every open phase
inline constexpr std::uint16_t kReadWriteConfiguring = kRead | kWriteConfiguring;  ///< settings of the process data
}  // namespace access

/// Where the value of a row is stored. Rows with the same number are aliases: one value, several addresses.
namespace slot {
inline constexpr std::uint16_t kOwn = 0xFFFF;       ///< the table gives the row a place of its own
inline constexpr std::uint16_t kConstant = 0xFFFE;  ///< never changes: the row's `initial`
}  // namespace slot

/// Row of an object dictionary table. Numbers up to 53 bits and REAL32 are exact in a double.
struct EntryRow {
  std::uint16_t index = 0;                            ///< of the object
  std::uint8_t subindex = 0;                          ///< 0 for the only value of a VAR
  esi::ObjectCode code = esi::ObjectCode::kVariable;  ///< of the whole object, the same in all its rows
  esi::DataType type = esi::DataType::kUnsigned32;    ///< of this sub-index
  /// access rights: bits of namespace access
  std::uint16_t access = access::kRead;
  std::uint16_t slot = slot::kOwn;  ///< where the value lives, see namespace slot
  std::string_view name{};          ///< of the object in its first row, of the sub-index in the others
  double initial = 0.0;             ///< value after power-on, when nothing is stored; rows kept as bytes have `text`
  double minimum = -std::numeric_limits<double>::infinity();  ///< infinite: the limit of the data type
  double maximum = std::numeric_limits<double>::infinity();   ///< infinite: the limit of the data type
  std::string_view unit{};                                    ///< for people, as SDO information tells it; empty: none
  /// Initial value of a row that is kept as bytes, or of a 64-bit number that no double holds (its eight bytes).
  std::string_view text{};
  std::uint16_t string_length = 0;  ///< rows kept as bytes: declared length; shorter contents are padded with zeros
  std::uint16_t record_type = 0;    ///< data type index of a RECORD (ETG.1000.6 Table 64), first row
  bool power_off_only = false;      ///< may only be written while the power stage is off
  std::string_view source{};        ///< where the facts come from; "ours" marks what no source states
  std::uint16_t bit_length = 0;     ///< 0: as the data type has it
  std::uint32_t bit_offset = kBehindPrevious;  ///< in complete access; SI 0 is at 0 and the next entry at bit 16

  /// The entry begins where the one before ends, or at the next byte where its type wants that.
  static constexpr std::uint32_t kBehindPrevious = 0xFFFFFFFF;
};

/// INTEGER8 to INTEGER64; a REAL is none of them. \rtsafe
[[nodiscard]] constexpr bool is_signed(esi::DataType type) noexcept {
  return type == esi::DataType::kInteger8 || type == esi::DataType::kInteger16 || type == esi::DataType::kInteger32 ||
         type == esi::DataType::kInteger64;
}

/// Bits of a BIT1 to BIT8; 0 for other types.
[[nodiscard]] constexpr std::uint8_t bit_field_size(esi::DataType type) noexcept {
  const auto first = static_cast<unsigned>(esi::DataType::kBit1);
  const auto last = static_cast<unsigned>(esi::DataType::kBit8);
  const auto code = static_cast<unsigned>(type);
  return code >= first && code <= last ? static_cast<std::uint8_t>(code - first + 1) : std::uint8_t{0};
}

/// Bytes of a number of `type` in an SDO; 0 for strings and other types that are kept as bytes.
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

/// Values of `type` are kept as bytes, not as a number.
[[nodiscard]] constexpr bool is_string(esi::DataType type) noexcept {
  return byte_size(type) == 0;
}

/// Bytes of the row in an SDO; its declared length when it is kept as bytes. \rtsafe
[[nodiscard]] constexpr std::size_t byte_size(const EntryRow& row) noexcept {
  return is_string(row.type) ? row.string_length : byte_size(row.type);
}

/// Bits the row occupies in process data and complete access. A BOOLEAN has one (ETG.1020, base data types).
[[nodiscard]] constexpr std::size_t bit_size(const EntryRow& row) noexcept {
  if (row.bit_length != 0) return row.bit_length;
  if (row.type == esi::DataType::kBoolean) return 1;
  const std::size_t field = bit_field_size(row.type);
  return field != 0 ? field : 8 * byte_size(row);
}

/// Raw 64 bits of `number` as a value of `type`: two's complement sign extended, or the IEEE 754 bits of a REAL.
[[nodiscard]] std::uint64_t raw_from_number(esi::DataType type, double number) noexcept;
/// The number a raw value stands for.
[[nodiscard]] double number_from_raw(esi::DataType type, std::uint64_t raw) noexcept;
/// The raw value a numeric row starts with.
[[nodiscard]] std::uint64_t initial_raw(const EntryRow& row) noexcept;

/// Name of the sub-index: entry 0 of the standard's arrays and records is their length, while the manufacturer's
/// parameters start with data at 0.
[[nodiscard]] constexpr std::string_view entry_name(const EntryRow& row) noexcept {
  const bool standard = row.index < 0x2000 || row.index >= 0x6000;
  const bool length = standard && row.subindex == 0 && row.code != esi::ObjectCode::kVariable;
  return length ? std::string_view{"Number of entries"} : row.name;
}

}  // namespace driveline::slaves
