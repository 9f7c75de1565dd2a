#include "text/soe_text.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <system_error>

#include "driveline/bytes/endian.hpp"

namespace driveline::cli {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;

/// The number in at most eight bytes, little-endian.
std::uint64_t number_of(std::span<const std::byte> bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) number |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  return number;
}

std::int64_t signed_number_of(std::span<const std::byte> bytes) {
  const auto unused = 64 - 8 * bytes.size();
  return static_cast<std::int64_t>(number_of(bytes) << unused) >> unused;
}

double real_of(std::span<const std::byte> bytes) {
  const auto bits = number_of(bytes);
  return bytes.size() == sizeof(float) ? double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))}
                                       : std::bit_cast<double>(bits);
}

/// Whether elements are real numbers, of four or eight bytes; shorter ones are shown as integers.
bool is_real(const SoeAttribute& attribute) {
  return attribute.display == SoeDisplay::kFloat && attribute.element_size() >= sizeof(float);
}

bool is_text(const SoeAttribute& attribute) {
  return attribute.display == SoeDisplay::kText && attribute.element_size() == 1;
}

bool is_idn(const SoeAttribute& attribute) {
  return attribute.display == SoeDisplay::kIdn && attribute.element_size() == sizeof(wire::Idn::raw);
}

std::string characters(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  return text;
}

/// Replaces characters in a text of the drive that would control a terminal.
std::string shown(std::string text) {
  for (auto& character : text) {
    if (static_cast<unsigned char>(character) < ' ' || character == '\x7F') character = '.';
  }
  return text;
}

std::string hex_digits(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes)
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", std::to_integer<unsigned>(byte));
  return text;
}

std::string element_text(std::span<const std::byte> bytes, const SoeAttribute& attribute) {
  const auto number = number_of(bytes);
  if (is_real(attribute)) return fmt::format("{}", real_of(bytes));
  if (is_idn(attribute)) return idn_text(wire::Idn{static_cast<std::uint16_t>(number)});
  switch (attribute.display) {
    case SoeDisplay::kBinary:
      return fmt::format("0b{:0{}b}", number, 8 * bytes.size());
    case SoeDisplay::kHexadecimal:
      return fmt::format("0x{:0{}X}", number, 2 * bytes.size());
    case SoeDisplay::kSigned:
      return fmt::format("{}", signed_number_of(bytes));
    default:
      return fmt::format("{}", number);
  }
}

nlohmann::json element_json(std::span<const std::byte> bytes, const SoeAttribute& attribute) {
  if (is_real(attribute)) return real_of(bytes);
  if (is_idn(attribute)) return element_text(bytes, attribute);
  if (attribute.display == SoeDisplay::kSigned) return signed_number_of(bytes);
  return number_of(bytes);
}

/// Whether the value consists of whole elements: a single one or, in a list, any number.
bool fits(std::span<const std::byte> value, const SoeAttribute& attribute) {
  const auto size = attribute.element_size();
  return attribute.list ? value.size() % size == 0 : value.size() == size;
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
  if (const auto idn = wire::Idn::from_text(text); idn && is_idn(attribute)) return idn->raw;
  return is_real(attribute) ? parse_real(text, attribute.element_size())
                            : parse_integer(text, attribute.element_size());
}

std::string_view display_text(SoeDisplay display) {
  switch (display) {
    case SoeDisplay::kBinary:
      return "binary";
    case SoeDisplay::kUnsigned:
      return "unsigned";
    case SoeDisplay::kSigned:
      return "signed";
    case SoeDisplay::kHexadecimal:
      return "hexadecimal";
    case SoeDisplay::kText:
      return "text";
    case SoeDisplay::kIdn:
      return "IDN";
    case SoeDisplay::kFloat:
      return "float";
    case SoeDisplay::kReserved:
      break;
  }
  return "reserved";
}

std::vector<std::string> protected_in(const SoeAttribute& attribute) {
  std::vector<std::string> states;
  if (attribute.pre_op_protected) states.emplace_back("PREOP");
  if (attribute.safe_op_protected) states.emplace_back("SAFEOP");
  if (attribute.op_protected) states.emplace_back("OP");
  return states;
}

std::string attribute_text(const SoeAttribute& attribute) {
  const auto size = attribute.element_size();
  auto text = fmt::format("{}{} byte{}, {}", attribute.list ? "list of " : "", size, size == 1 ? "" : "s",
                          display_text(attribute.display));
  if (attribute.command) text += ", procedure command";
  if (attribute.decimals != 0) text += fmt::format(", {} decimals", attribute.decimals);
  if (attribute.conversion_factor != 1) text += fmt::format(", factor {}", attribute.conversion_factor);
  std::string states;
  for (const auto& state : protected_in(attribute)) states += (states.empty() ? "" : ", ") + state;
  if (!states.empty()) text += fmt::format(", protected in {}", states);
  return text;
}

}  // namespace

std::string idn_text(wire::Idn idn) {
  const auto text = idn.text();
  return {text.begin(), text.end()};
}

std::string soe_value_text(std::span<const std::byte> value, const SoeAttribute& attribute) {
  if (!fits(value, attribute)) return hex_digits(value);
  if (!attribute.list) return element_text(value, attribute);
  if (is_text(attribute)) return shown(characters(value));
  std::string text;
  for (; !value.empty(); value = value.subspan(attribute.element_size())) {
    if (!text.empty()) text += ", ";
    text += element_text(value.first(attribute.element_size()), attribute);
  }
  return "[" + text + "]";
}

nlohmann::json soe_value_json(std::span<const std::byte> value, const SoeAttribute& attribute) {
  if (!fits(value, attribute)) return hex_digits(value);
  if (!attribute.list) return element_json(value, attribute);
  if (is_text(attribute)) return characters(value);
  auto elements = nlohmann::json::array();
  for (; !value.empty(); value = value.subspan(attribute.element_size())) {
    elements.push_back(element_json(value.first(attribute.element_size()), attribute));
  }
  return elements;
}

Outcome<std::vector<std::byte>> parse_soe_value(std::string_view text, const SoeAttribute& attribute) {
  std::vector<std::byte> value;
  if (attribute.list && is_text(attribute)) {
    const auto bytes = std::as_bytes(std::span(text));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }
  if (attribute.list && text.empty()) return value;
  for (bool more = true; more;) {
    const auto end = attribute.list ? text.find(',') : std::string_view::npos;
    more = end != std::string_view::npos;
    auto part = text.substr(0, end);
    while (part.starts_with(' ')) part.remove_prefix(1);
    const auto number = parse_element(part, attribute);
    if (!number) {
      return misused(fmt::format("\"{}\" is not a value of {} byte{}, {}", part, attribute.element_size(),
                                 attribute.element_size() == 1 ? "" : "s", display_text(attribute.display)));
    }
    const auto bytes = bytes::to_le_bytes(*number);
    value.insert(value.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(attribute.element_size()));
    if (more) text.remove_prefix(end + 1);
  }
  return value;
}

std::string soe_parameter_text(wire::Idn idn, const ecat_master::SoeParameter& parameter) {
  const auto& attribute = *parameter.attribute;
  auto text = fmt::format("{}  {}\n", idn_text(idn), shown(parameter.name.value_or("")));
  const auto line = [&text](std::string_view name, std::string_view content) {
    text += fmt::format("  {:<10}{}\n", name, content);
  };
  const auto datum = [&](std::string_view name, const std::optional<std::vector<std::byte>>& bytes) {
    if (bytes) line(name, soe_value_text(*bytes, attribute));
  };
  datum("value", parameter.value);
  if (parameter.unit) line("unit", shown(*parameter.unit));
  datum("minimum", parameter.min);
  datum("maximum", parameter.max);
  datum("default", parameter.preset);
  if (parameter.state) {
    line("state", fmt::format("0x{:04X} ({})", *parameter.state,
                              wire::to_text(static_cast<wire::SoeCommandState>(*parameter.state))));
  }
  line("attribute", attribute_text(attribute));
  return text;
}

std::string soe_line_text(wire::Idn idn, const ecat_master::SoeParameter& parameter) {
  const auto value = parameter.value ? soe_value_text(*parameter.value, *parameter.attribute) : std::string("-");
  auto line = fmt::format("{}  {:<34}{}", idn_text(idn), shown(parameter.name.value_or("")), value);
  if (parameter.unit) line += " " + shown(*parameter.unit);
  return line;
}

nlohmann::json soe_parameter_json(wire::Idn idn, const ecat_master::SoeParameter& parameter) {
  const auto& attribute = *parameter.attribute;
  const auto datum = [&](const std::optional<std::vector<std::byte>>& bytes) {
    return bytes ? soe_value_json(*bytes, attribute) : nlohmann::json(nullptr);
  };
  const auto text = [](const std::optional<std::string>& known) {
    return known ? nlohmann::json(*known) : nlohmann::json(nullptr);
  };
  return {{"idn", idn_text(idn)},
          {"name", text(parameter.name)},
          {"value", datum(parameter.value)},
          {"unit", text(parameter.unit)},
          {"minimum", datum(parameter.min)},
          {"maximum", datum(parameter.max)},
          {"default", datum(parameter.preset)},
          {"state", parameter.state ? nlohmann::json(*parameter.state) : nlohmann::json(nullptr)},
          {"attribute",
           {{"bytes", attribute.element_size()},
            {"list", attribute.list},
            {"command", attribute.command},
            {"display", display_text(attribute.display)},
            {"decimals", attribute.decimals},
            {"conversion_factor", attribute.conversion_factor},
            {"protected", protected_in(attribute)}}}};
}

}  // namespace driveline::cli
