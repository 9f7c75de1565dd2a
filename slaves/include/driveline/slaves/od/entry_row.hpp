#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "driveline/esi/device_description.hpp"

/// One row of a device's object dictionary table: everything that is known about one sub-index, in one place.
namespace driveline::slaves {

/// Object access bits as the SDO information service reports them (ETG.1000.6 5.6.3.6, object access).
namespace access {
inline constexpr std::uint16_t kReadPreOp = 0x0001;
inline constexpr std::uint16_t kReadSafeOp = 0x0002;
inline constexpr std::uint16_t kReadOp = 0x0004;
inline constexpr std::uint16_t kWritePreOp = 0x0008;
inline constexpr std::uint16_t kWriteSafeOp = 0x0010;
inline constexpr std::uint16_t kWriteOp = 0x0020;
inline constexpr std::uint16_t kRxMappable = 0x0040;
inline constexpr std::uint16_t kTxMappable = 0x0080;
inline constexpr std::uint16_t kBackup = 0x0100;  ///< kept by "store parameters"
inline constexpr std::uint16_t kRead = kReadPreOp | kReadSafeOp | kReadOp;
inline constexpr std::uint16_t kWrite = kWritePreOp | kWriteSafeOp | kWriteOp;
inline constexpr std::uint16_t kReadWrite = kRead | kWrite;
inline constexpr std::uint16_t kReadWritePreOp = kRead | kWritePreOp;  ///< settings of the process data
}  // namespace access

/// Where the value of a row lives. Rows with the same number are aliases: one value, several addresses.
namespace slot {
inline constexpr std::uint16_t kOwn = 0xFFFF;       ///< the table gives the row a place of its own
inline constexpr std::uint16_t kConstant = 0xFFFE;  ///< never changes: the row's `initial`
}  // namespace slot

/// Row of an object dictionary table. Numbers of every type, REAL32 included, are exact in a double.
struct EntryRow {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  esi::ObjectCode code = esi::ObjectCode::kVariable;  ///< of the whole object, the same in all its rows
  esi::DataType type = esi::DataType::kUnsigned32;
  std::uint16_t access = access::kRead;
  std::uint16_t slot = slot::kOwn;
  std::string_view name{};  ///< of the object in its first row, of the sub-index in the others
  double initial = 0.0;
  double minimum = -std::numeric_limits<double>::infinity();  ///< infinite: the limit of the data type
  double maximum = std::numeric_limits<double>::infinity();
  std::string_view unit{};
  std::string_view text{};          ///< initial value of a string
  std::uint16_t string_length = 0;  ///< strings: declared length; shorter contents are padded with zeros
  std::uint16_t record_type = 0;    ///< data type index of a RECORD (ETG.1000.6 Table 64), first row
  bool power_off_only = false;      ///< may only be written while the power stage is off
  std::string_view source{};        ///< where the facts come from; "ours" marks what no source states
};

[[nodiscard]] constexpr bool is_string(esi::DataType type) noexcept {
  return type == esi::DataType::kVisibleString || type == esi::DataType::kOctetString;
}

[[nodiscard]] constexpr bool is_signed(esi::DataType type) noexcept {
  return type == esi::DataType::kInteger8 || type == esi::DataType::kInteger16 || type == esi::DataType::kInteger32;
}

/// Bytes of a number of `type` on the wire; 0 for strings and types this dictionary does not hold.
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
    default:
      return 0;
  }
}

[[nodiscard]] constexpr std::size_t byte_size(const EntryRow& row) noexcept {
  return is_string(row.type) ? row.string_length : byte_size(row.type);
}

/// Raw 32 bits of `number` as a value of `type`: two's complement sign extended, or the IEEE 754 bits of a REAL32.
[[nodiscard]] std::uint32_t raw_from_number(esi::DataType type, double number) noexcept;
/// The number a raw value stands for.
[[nodiscard]] double number_from_raw(esi::DataType type, std::uint32_t raw) noexcept;

/// Name of the sub-index: entry 0 of the standard's arrays and records is their length, while the manufacturer's
/// parameters start with data at 0.
[[nodiscard]] constexpr std::string_view entry_name(const EntryRow& row) noexcept {
  const bool standard = row.index < 0x2000 || row.index >= 0x6000;
  const bool length = standard && row.subindex == 0 && row.code != esi::ObjectCode::kVariable;
  return length ? std::string_view{"Number of entries"} : row.name;
}

}  // namespace driveline::slaves
