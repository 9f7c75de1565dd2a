#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/esi/data_type.hpp"

namespace driveline::esi {

/// Bit rates of an electronic data sheet in kbit/s (CiA 306-1, DeviceInfo).
inline constexpr std::array<std::uint16_t, 8> kEdsBitRates{10, 20, 50, 125, 250, 500, 800, 1000};

/// A number of an electronic data sheet.
struct EdsNumber {
  std::uint64_t magnitude = 0;  ///< absolute value
  bool negative = false;
  bool adds_node_id = false;  ///< the formula contains $NODEID
};

/// Parses a decimal number, a hexadecimal one with 0x, an octal one with a leading 0, or the sum of one and $NODEID
/// (CiA 306-1 "Values"), in any letter case and with any white space. Digits beyond 7 behind a leading 0 make a number
/// decimal. None: the text is something else, or the number exceeds 64 bits.
[[nodiscard]] std::optional<EdsNumber> parse_eds_number(std::string_view text);

/// Bits of a number of this type; 0: not a number.
[[nodiscard]] std::uint16_t bits_of_number(DataType type) noexcept;

/// Returns the little-endian hex digits of a number; none: it does not fit the type, or this is not a type of numbers.
/// Hexadecimal numbers of a signed type may be its two's complement.
[[nodiscard]] std::optional<std::string> hex_of_number(DataType type, const EdsNumber& number);

/// Returns the little-endian hex digits of a value as a file writes it: a number, also with a fraction, a text, or hex
/// digits of bytes. `adds_node_id` is set if it is a formula with the node-ID. None: it is not a value of this type.
[[nodiscard]] std::optional<std::string> hex_of_value(DataType type, std::string_view text, bool& adds_node_id);

/// Returns a number as a file writes it, from its little-endian hex digits: unsigned ones with 0x, signed ones and
/// those with a fraction decimal, because other programs take 0x80000000 for a positive number. Empty for no digits.
[[nodiscard]] std::string text_of_number(DataType type, const std::string& hex);

/// Returns the little-endian hex digits of `hex`, a number, plus `addend`, which wraps at its length.
[[nodiscard]] std::string plus(const std::string& hex, std::uint8_t addend);

}  // namespace driveline::esi
