#pragma once

#include <array>

#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

/// Helpers for the rows of the table, only for its implementation: a row takes one or two lines. A row with a named
/// value has the type of its slot.
namespace driveline::slaves::msd {

inline constexpr std::uint16_t kStored = access::kReadWrite | access::kBackup;
inline constexpr std::uint16_t kRx = access::kReadWrite | access::kRxMappable | access::kTxMappable;
inline constexpr std::uint16_t kRxStored = kRx | access::kBackup;
inline constexpr std::uint16_t kTx = access::kRead | access::kTxMappable;

/// Returns the index of a P-parameter: 2000h + number; its sub-index is the parameter index, from 0 (MSD manual 8.2.3,
/// 8.2.5).
constexpr std::uint16_t p(std::uint16_t number) {
  return static_cast<std::uint16_t>(0x2000 + number);
}

struct RowRange {
  double initial = 0.0;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};
/// The minimum of the data type.
inline constexpr double kNoMinimum = RowRange{}.minimum;

/// Returns an object without sub-indices whose value has a slot of its own.
constexpr EntryRow variable(std::uint16_t index, esi::DataType type, std::uint16_t access, std::string_view name,
                            RowRange range, std::string_view unit, std::string_view source) {
  return {.index = index,
          .type = type,
          .access = access,
          .name = name,
          .initial = range.initial,
          .minimum = range.minimum,
          .maximum = range.maximum,
          .unit = unit,
          .source = source};
}

/// Returns an object without sub-indices.
template <typename T>
constexpr EntryRow variable(std::uint16_t index, std::uint16_t access, Slot<T> value, std::string_view name,
                            RowRange range, std::string_view unit, std::string_view source) {
  EntryRow row = variable(index, data_type<T>(), access, name, range, unit, source);
  row.slot = value.number;
  return row;
}

/// Returns a sub-index of an ARRAY.
template <typename T>
constexpr EntryRow element(std::uint16_t index, std::uint8_t subindex, std::uint16_t access, Slot<T> value,
                           std::string_view name, RowRange range, std::string_view unit, std::string_view source) {
  EntryRow row = variable(index, access, value, name, range, unit, source);
  row.subindex = subindex;
  row.code = esi::ObjectCode::kArray;
  return row;
}

/// Returns a sub-index of a RECORD.
template <typename T>
constexpr EntryRow field(std::uint16_t index, std::uint8_t subindex, std::uint16_t access, Slot<T> value,
                         std::string_view name, RowRange range, std::string_view unit, std::string_view source) {
  EntryRow row = element(index, subindex, access, value, name, range, unit, source);
  row.code = esi::ObjectCode::kRecord;
  return row;
}

/// Returns a value that never changes.
constexpr EntryRow constant(std::uint16_t index, std::uint8_t subindex, esi::ObjectCode code, esi::DataType type,
                            std::string_view name, double value, std::string_view source) {
  return {.index = index,
          .subindex = subindex,
          .code = code,
          .type = type,
          .slot = slot::kConstant,
          .name = name,
          .initial = value,
          .source = source};
}

/// Returns sub-index 0 of a standard ARRAY: the number of further entries.
constexpr EntryRow array_length(std::uint16_t index, std::string_view name, std::uint8_t entries,
                                std::string_view source) {
  return constant(index, 0, esi::ObjectCode::kArray, esi::DataType::kUnsigned8, name, entries, source);
}

/// Returns sub-index 0 of a standard RECORD of this data type: the number of further entries.
constexpr EntryRow record_length(std::uint16_t index, std::uint16_t record_type, std::string_view name,
                                 std::uint8_t entries, std::string_view source) {
  EntryRow row = constant(index, 0, esi::ObjectCode::kRecord, esi::DataType::kUnsigned8, name, entries, source);
  row.record_type = record_type;
  return row;
}

/// Returns a text without sub-indices.
constexpr EntryRow text(std::uint16_t index, std::uint16_t access, std::string_view name, std::string_view content,
                        std::uint16_t length, std::string_view source) {
  EntryRow row = variable(index, esi::DataType::kVisibleString, access, name, {}, {}, source);
  row.text = content;
  row.string_length = length;
  return row;
}

/// Makes the row writable only while the power stage is off.
constexpr EntryRow power_off(EntryRow row) {
  row.power_off_only = true;
  return row;
}

}  // namespace driveline::slaves::msd
