#include "driveline/ecat_master/soe/soe_value.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <optional>
#include <system_error>

#include "driveline/bytes/endian.hpp"

namespace driveline::ecat_master {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;

double real_of(std::span<const std::byte> bytes) {
  const auto bits = unsigned_number(bytes);
  return bytes.size() == sizeof(float) ? double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))}
                                       : std::bit_cast<double>(bits);
}

std::string element_text(std::span<const std::byte> bytes, const SoeAttribute& attribute) {
  const auto number = unsigned_number(bytes);
  if (is_soe_real(attribute)) return fmt::format("{}", real_of(bytes));
  if (is_soe_idn(attribute)) return idn_text(wire::Idn{static_cast<std::uint16_t>(number)});
  switch (attribute.display) {
    case SoeDisplay::kBinary:
      return fmt::format("0b{:0{}b}", number, 8 * bytes.size());
    case SoeDisplay::kHexadecimal:
      return fmt::format("0x{:0{}X}", number, 2 * bytes.size());
    case SoeDisplay::kSigned:
      return fmt::format("{}", signed_number(bytes));
    default:
      return fmt::format("{}", number);
  }
}

template <typename T>
bool read_number(std::string_view text, T& number, int base) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size();
}

/// Parses a signed integer, or a bit pattern after 0x or 0b; nothing: the text is no integer of this size.
std::optional<std::uint64_t> parse_integer(std::string_view text, std::size_t size) {
  const unsigned bits = static_cast<unsigned>(8 * size);
  std::uint64_t number = 0;
  if (text.starts_with('-')) {
    std::int64_t negative = 0;
    if (!read_number(text, negative, 10) || (bits < 64 && negative < -(std::int64_t{1} << (bits - 1)))) {
      return std::nullopt;
    }
    return static_cast<std::uint64_t>(negative);
  }
  const int base = text.starts_with("0x") ? 16 : text.starts_with("0b") ? 2 : 10;
  if (base != 10) text.remove_prefix(2);
  if (!read_number(text, number, base) || (bits < 64 && number >> bits != 0)) return std::nullopt;
  return number;
}

std::optional<std::uint64_t> parse_real(std::string_view text, std::size_t size) {
  double number = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return size == sizeof(float) ? std::bit_cast<std::uint32_t>(static_cast<float>(number))
                               : std::bit_cast<std::uint64_t>(number);
}

std::optional<std::uint64_t> parse_element(std::string_view text, const SoeAttribute& attribute) {
  if (const auto idn = wire::Idn::from_text(text); idn && is_soe_idn(attribute)) return idn->raw;
  return is_soe_real(attribute) ? parse_real(text, attribute.element_size())
                                : parse_integer(text, attribute.element_size());
}

std::string characters(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  return text;
}

}  // namespace

std::uint64_t unsigned_number(std::span<const std::byte> bytes) noexcept {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) number |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  return number;
}

std::int64_t signed_number(std::span<const std::byte> bytes) noexcept {
  if (bytes.empty()) return 0;
  const auto unused = 64 - 8 * bytes.size();
  return static_cast<std::int64_t>(unsigned_number(bytes) << unused) >> unused;
}

std::string idn_text(wire::Idn idn) {
  const auto text = idn.text();
  return {text.begin(), text.end()};
}

std::string hex_digits(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes)
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", std::to_integer<unsigned>(byte));
  return text;
}

std::string printable(std::string text) {
  for (auto& character : text) {
    if (static_cast<unsigned char>(character) < ' ' || character == '\x7F') character = '.';
  }
  return text;
}

bool is_soe_text(const SoeAttribute& attribute) noexcept {
  return attribute.display == SoeDisplay::kText && attribute.element_size() == 1;
}

bool is_soe_idn(const SoeAttribute& attribute) noexcept {
  return attribute.display == SoeDisplay::kIdn && attribute.element_size() == sizeof(wire::Idn::raw);
}

bool is_soe_real(const SoeAttribute& attribute) noexcept {
  return attribute.display == SoeDisplay::kFloat && attribute.element_size() >= sizeof(float);
}

bool is_whole(std::span<const std::byte> value, const SoeAttribute& attribute) noexcept {
  const auto size = attribute.element_size();
  return attribute.list ? value.size() % size == 0 : value.size() == size;
}

std::string soe_value_text(std::span<const std::byte> value, const SoeAttribute& attribute) {
  if (!is_whole(value, attribute)) return hex_digits(value);
  if (!attribute.list) return element_text(value, attribute);
  if (is_soe_text(attribute)) return printable(characters(value));
  std::string text;
  for (; !value.empty(); value = value.subspan(attribute.element_size())) {
    if (!text.empty()) text += ", ";
    text += element_text(value.first(attribute.element_size()), attribute);
  }
  return "[" + text + "]";
}

double soe_number(std::span<const std::byte> value, const SoeAttribute& attribute) noexcept {
  const auto size = attribute.element_size();
  if (value.size() < size) return 0.0;
  value = value.first(size);
  if (is_soe_real(attribute)) return real_of(value);
  if (attribute.display == SoeDisplay::kSigned) return static_cast<double>(signed_number(value));
  return static_cast<double>(unsigned_number(value));
}

std::optional<std::vector<std::byte>> encode_soe_element(std::string_view text, const SoeAttribute& attribute) {
  const auto number = parse_element(text, attribute);
  if (!number) return std::nullopt;
  const auto bytes = bytes::to_le_bytes(*number);
  return std::vector<std::byte>(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(attribute.element_size()));
}

}  // namespace driveline::ecat_master
