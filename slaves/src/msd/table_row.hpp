#pragma once

#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

/// Short forms for rows of the table, for the implementation of the table only.
namespace driveline::slaves::msd {

inline constexpr std::uint16_t kStored = access::kReadWrite | access::kBackup;
inline constexpr std::uint16_t kRx = access::kReadWrite | access::kRxMappable | access::kTxMappable;
inline constexpr std::uint16_t kRxStored = kRx | access::kBackup;
inline constexpr std::uint16_t kTx = access::kRead | access::kTxMappable;

/// P-parameter: index 2000h + number, sub-index = parameter index, 0 included (MSD manual 8.2.3, 8.2.5).
constexpr std::uint16_t p(std::uint16_t number) {
  return static_cast<std::uint16_t>(0x2000 + number);
}

struct RowRange {
  double initial = 0.0;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};

/// One object without sub-indices.
constexpr EntryRow variable(std::uint16_t index, esi::DataType type, std::uint16_t access, std::uint16_t slot,
                            std::string_view name, RowRange range, std::string_view unit, std::string_view source) {
  return {.index = index,
          .type = type,
          .access = access,
          .slot = slot,
          .name = name,
          .initial = range.initial,
          .minimum = range.minimum,
          .maximum = range.maximum,
          .unit = unit,
          .source = source};
}

/// One sub-index of an ARRAY.
constexpr EntryRow element(std::uint16_t index, std::uint8_t subindex, esi::DataType type, std::uint16_t access,
                           std::uint16_t slot, std::string_view name, RowRange range, std::string_view unit,
                           std::string_view source) {
  EntryRow row = variable(index, type, access, slot, name, range, unit, source);
  row.subindex = subindex;
  row.code = esi::ObjectCode::kArray;
  return row;
}

/// Sub-index 0 of a standard ARRAY: how many follow.
constexpr EntryRow array_length(std::uint16_t index, std::string_view name, std::uint8_t entries,
                                std::string_view source) {
  return element(index, 0, esi::DataType::kUnsigned8, access::kRead, slot::kConstant, name, {double{} + entries}, {},
                 source);
}

}  // namespace driveline::slaves::msd
