#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

/// Helpers for the rows of the table, only for its implementation: a row takes one or two lines.
namespace driveline::slaves::msd::sercos {

using idn_use::kAt;
using idn_use::kMdt;
using idn_use::kSaved;
using idn_use::kStored;

/// Types of the values.
inline constexpr wire::SoeAttribute kU16{.length_code = 1, .display = wire::SoeDisplay::kUnsigned};
inline constexpr wire::SoeAttribute kU32{.length_code = 2, .display = wire::SoeDisplay::kUnsigned};
inline constexpr wire::SoeAttribute kI16{.length_code = 1, .display = wire::SoeDisplay::kSigned};
inline constexpr wire::SoeAttribute kI32{.length_code = 2, .display = wire::SoeDisplay::kSigned};
inline constexpr wire::SoeAttribute kBits16{.length_code = 1, .display = wire::SoeDisplay::kBinary};
inline constexpr wire::SoeAttribute kBits32{.length_code = 2, .display = wire::SoeDisplay::kBinary};
inline constexpr wire::SoeAttribute kHex16{.length_code = 1, .display = wire::SoeDisplay::kHexadecimal};
inline constexpr wire::SoeAttribute kHex32{.length_code = 2, .display = wire::SoeDisplay::kHexadecimal};
inline constexpr wire::SoeAttribute kReal{.length_code = 2, .display = wire::SoeDisplay::kFloat};
inline constexpr wire::SoeAttribute kIdnNumber{.length_code = 1, .display = wire::SoeDisplay::kIdn};
inline constexpr wire::SoeAttribute kCommand{.length_code = 1, .command = true, .display = wire::SoeDisplay::kBinary};

constexpr wire::SoeAttribute decimals(wire::SoeAttribute type, std::uint8_t places) {
  type.decimals = places;
  return type;
}

constexpr wire::SoeAttribute list_of(wire::SoeAttribute element) {
  element.list = true;
  return element;
}

inline constexpr wire::SoeAttribute kIdns = list_of(kIdnNumber);
inline constexpr wire::SoeAttribute kWords = list_of(kU16);
inline constexpr wire::SoeAttribute kLongs = list_of(kI32);
inline constexpr wire::SoeAttribute kHexWords = list_of(kHex16);
inline constexpr wire::SoeAttribute kHexLongs = list_of(kHex32);
inline constexpr wire::SoeAttribute kReals = list_of(kReal);
inline constexpr wire::SoeAttribute kText{.length_code = 0, .list = true, .display = wire::SoeDisplay::kText};

/// Weighted values with the decimal places of the preferred rotary weighting: 0.0001 degrees, 0.0001 1/min,
/// 0.001 rad/s2; torque in 0.1 %; temperature in 0.1 degrees Celsius (SERCOS manual 1113, 1210, 1292, 1333).
inline constexpr wire::SoeAttribute kPos = decimals(kI32, 4);
inline constexpr wire::SoeAttribute kPosSize = decimals(kU32, 4);
inline constexpr wire::SoeAttribute kSpeed = decimals(kI32, 4);
inline constexpr wire::SoeAttribute kSpeedSize = decimals(kU32, 4);
inline constexpr wire::SoeAttribute kAccSize = decimals(kU32, 3);
inline constexpr wire::SoeAttribute kTorque = decimals(kI16, 1);
inline constexpr wire::SoeAttribute kTorqueSize = decimals(kU16, 1);
inline constexpr wire::SoeAttribute kTemp = decimals(kI16, 1);

/// Phases that allow a write.
enum class Writable : std::uint8_t { kNever, kCp2, kCp23, kCp3, kAlways };
using enum Writable;

struct IdnRange {
  double initial = 0.0;
  double minimum = IdnRow{}.minimum;
  double maximum = IdnRow{}.maximum;
};
inline constexpr double kNone = IdnRow{}.minimum;       ///< no minimum
inline constexpr double kNoneAbove = IdnRow{}.maximum;  ///< no maximum

/// Returns the raw number of a P parameter (SERCOS manual 398).
constexpr std::uint16_t p_raw(std::uint16_t number) {
  return static_cast<std::uint16_t>(0x8000 + number);
}

constexpr IdnRow idn_row(std::uint16_t raw, std::string_view name, std::string_view unit, wire::SoeAttribute type,
                         Writable writable, IdnRange range, std::uint8_t uses, std::uint16_t line,
                         std::string_view source) {
  type.pre_op_protected = writable == kNever || writable == kCp3;
  type.safe_op_protected = writable == kNever || writable == kCp2;
  type.op_protected = writable != kAlways;
  return {.idn = {raw},
          .name = name,
          .attribute = type,
          .unit = unit,
          .initial = range.initial,
          .minimum = range.minimum,
          .maximum = range.maximum,
          .has_default = (uses & kSaved) != 0 && !type.list,
          .uses = uses,
          .line = line,
          .source = source};
}

/// Returns an IDN of the standard.
constexpr IdnRow s(std::uint16_t number, std::string_view name, std::string_view unit, wire::SoeAttribute type,
                   Writable writable, IdnRange range, std::uint8_t uses, std::uint16_t line, std::string_view source) {
  return idn_row(number, name, unit, type, writable, range, uses, line, source);
}

/// Returns an IDN of the product.
constexpr IdnRow p(std::uint16_t number, std::string_view name, std::string_view unit, wire::SoeAttribute type,
                   Writable writable, IdnRange range, std::uint8_t uses, std::uint16_t line, std::string_view source) {
  return idn_row(p_raw(number), name, unit, type, writable, range, uses, line, source);
}

/// Returns a list that is empty after power-on.
constexpr IdnRow list(std::uint16_t capacity, IdnRow row) {
  row.capacity = capacity;
  return row;
}

/// Returns a list whose content never changes.
constexpr IdnRow words(std::span<const std::uint16_t> elements, IdnRow row) {
  row.capacity = static_cast<std::uint16_t>(elements.size_bytes());
  row.elements = elements;
  return row;
}

constexpr IdnRow text(std::uint16_t capacity, std::string_view content, IdnRow row) {
  row.capacity = capacity;
  row.text = content;
  return row;
}

/// Returns a list whose content follows from the table.
constexpr IdnRow selected(IdnSelection selection, IdnRow row) {
  row.selection = selection;
  return row;
}

[[nodiscard]] std::span<const IdnRow> standard_idns();
[[nodiscard]] std::span<const IdnRow> product_idns();

}  // namespace driveline::slaves::msd::sercos
