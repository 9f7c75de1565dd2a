#include "data_type_name.hpp"

#include <fmt/format.h>

#include <array>

namespace driveline::esi {
namespace {

struct Row {
  std::string_view name;
  DataType type;
};

/// The writer uses the first row of a type.
constexpr std::array kNames = {
    Row{"BOOL", DataType::kBoolean},        Row{"SINT", DataType::kInteger8},      Row{"INT", DataType::kInteger16},
    Row{"DINT", DataType::kInteger32},      Row{"LINT", DataType::kInteger64},     Row{"USINT", DataType::kUnsigned8},
    Row{"UINT", DataType::kUnsigned16},     Row{"UDINT", DataType::kUnsigned32},   Row{"ULINT", DataType::kUnsigned64},
    Row{"REAL", DataType::kReal32},         Row{"LREAL", DataType::kReal64},       Row{"BIT1", DataType::kBit1},
    Row{"BIT2", DataType::kBit2},           Row{"BIT3", DataType::kBit3},          Row{"BIT4", DataType::kBit4},
    Row{"BIT5", DataType::kBit5},           Row{"BIT6", DataType::kBit6},          Row{"BIT7", DataType::kBit7},
    Row{"BIT8", DataType::kBit8},           Row{"BIT", DataType::kBit1},           Row{"BYTE", DataType::kUnsigned8},
    Row{"WORD", DataType::kUnsigned16},     Row{"DWORD", DataType::kUnsigned32},   Row{"BITARR8", DataType::kUnsigned8},
    Row{"BITARR16", DataType::kUnsigned16}, Row{"BITARR32", DataType::kUnsigned32}};

constexpr std::string_view kStringPrefix = "STRING(";
constexpr std::string_view kArrayPrefix = "ARRAY [";
constexpr std::string_view kArraySuffix = "] OF BYTE";

}  // namespace

std::string data_type_name(DataType type, std::uint32_t bit_length) {
  const std::uint32_t bytes = bit_length / 8;
  if (type == DataType::kVisibleString) return fmt::format("STRING({})", bytes);
  for (const Row& row : kNames) {
    if (row.type == type) return std::string(row.name);
  }
  // Octet strings and types without a name are raw bytes.
  return fmt::format("ARRAY [0..{}] OF BYTE", bytes == 0 ? 0 : bytes - 1);
}

std::optional<DataType> data_type_of(std::string_view name) {
  for (const Row& row : kNames) {
    if (row.name == name) return row.type;
  }
  if (name.starts_with(kStringPrefix)) return DataType::kVisibleString;
  if (name.starts_with(kArrayPrefix) && name.ends_with(kArraySuffix)) return DataType::kOctetString;
  return std::nullopt;
}

std::optional<DataType> unsigned_type(std::uint32_t bit_length) {
  switch (bit_length) {
    case 8:
      return DataType::kUnsigned8;
    case 16:
      return DataType::kUnsigned16;
    case 32:
      return DataType::kUnsigned32;
    case 64:
      return DataType::kUnsigned64;
    default:
      break;
  }
  if (bit_length == 0 || bit_length > 8) return std::nullopt;
  return static_cast<DataType>(static_cast<std::uint32_t>(DataType::kBit1) + bit_length - 1);
}

}  // namespace driveline::esi
