#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// The IDN as "S-0-0017".
[[nodiscard]] std::string idn_text(wire::Idn idn);

/// The number in at most eight bytes, little endian.
[[nodiscard]] std::uint64_t unsigned_number(std::span<const std::byte> bytes) noexcept;
/// The same in two's complement; 0 for no bytes.
[[nodiscard]] std::int64_t signed_number(std::span<const std::byte> bytes) noexcept;
/// The bytes as "01 AB".
[[nodiscard]] std::string hex_digits(std::span<const std::byte> bytes);

/// A text of a drive with a dot for each character that would control a terminal.
[[nodiscard]] std::string printable(std::string text);

/// Whether a value of this attribute is a text: a list of characters.
[[nodiscard]] bool is_soe_text(const wire::SoeAttribute& attribute) noexcept;
/// Whether elements of this attribute are IDNs of two bytes.
[[nodiscard]] bool is_soe_idn(const wire::SoeAttribute& attribute) noexcept;
/// Whether elements are real numbers, of four or eight bytes; shorter ones are shown as integers.
[[nodiscard]] bool is_soe_real(const wire::SoeAttribute& attribute) noexcept;
/// Whether the bytes are whole elements: a single one or, in a list, any number of them.
[[nodiscard]] bool is_whole(std::span<const std::byte> value, const wire::SoeAttribute& attribute) noexcept;

/// The value in the display format of its attribute, a list in brackets; conversion factor and decimals are not
/// applied. Hexadecimal bytes if their number does not match the attribute.
[[nodiscard]] std::string soe_value_text(std::span<const std::byte> value, const wire::SoeAttribute& attribute);

/// The first element as a number; 0 for fewer bytes than an element has.
[[nodiscard]] double soe_number(std::span<const std::byte> value, const wire::SoeAttribute& attribute) noexcept;

/// Encodes one element: an integer, decimal or with 0x or 0b, a real number, or an IDN, as the attribute says. Empty:
/// the text is none that fits.
[[nodiscard]] std::optional<std::vector<std::byte>> encode_soe_element(std::string_view text,
                                                                       const wire::SoeAttribute& attribute);

}  // namespace driveline::ecat_master
