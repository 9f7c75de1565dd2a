#include "text/soe_text.hpp"

#include <fmt/format.h>

#include <cstdint>

#include "driveline/ecat_master/error/soe_display.hpp"

namespace driveline::cli {
namespace {

using ecat_master::display_text;
using wire::SoeAttribute;
using wire::SoeDisplay;

std::string characters(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  return text;
}

nlohmann::json element_json(std::span<const std::byte> bytes, const SoeAttribute& attribute) {
  if (ecat_master::is_soe_real(attribute)) return ecat_master::soe_number(bytes, attribute);
  if (ecat_master::is_soe_idn(attribute))
    return idn_text({static_cast<std::uint16_t>(ecat_master::unsigned_number(bytes))});
  if (attribute.display == SoeDisplay::kSigned) return ecat_master::signed_number(bytes);
  return ecat_master::unsigned_number(bytes);
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

nlohmann::json soe_value_json(std::span<const std::byte> value, const SoeAttribute& attribute) {
  if (!ecat_master::is_whole(value, attribute)) return ecat_master::hex_digits(value);
  if (!attribute.list) return element_json(value, attribute);
  if (ecat_master::is_soe_text(attribute)) return characters(value);
  auto elements = nlohmann::json::array();
  for (; !value.empty(); value = value.subspan(attribute.element_size())) {
    elements.push_back(element_json(value.first(attribute.element_size()), attribute));
  }
  return elements;
}

Outcome<std::vector<std::byte>> parse_soe_value(std::string_view text, const SoeAttribute& attribute) {
  std::vector<std::byte> value;
  if (attribute.list && ecat_master::is_soe_text(attribute)) {
    const auto bytes = std::as_bytes(std::span(text));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }
  if (attribute.list && text.empty()) return value;
  for (bool more = true; more;) {
    const auto end = attribute.list ? text.find(',') : std::string_view::npos;
    more = end != std::string_view::npos;
    auto part = text.substr(0, end);
    while (part.starts_with(' ')) part.remove_prefix(1);
    const auto element = ecat_master::encode_soe_element(part, attribute);
    if (!element) {
      return misused(fmt::format("\"{}\" is not a value of {} byte{}, {}", part, attribute.element_size(),
                                 attribute.element_size() == 1 ? "" : "s", display_text(attribute.display)));
    }
    value.insert(value.end(), element->begin(), element->end());
    if (more) text.remove_prefix(end + 1);
  }
  return value;
}

std::string soe_parameter_text(wire::Idn idn, const ecat_master::SoeParameter& parameter) {
  const auto& attribute = *parameter.attribute;
  auto text = fmt::format("{}  {}\n", idn_text(idn), ecat_master::printable(parameter.name.value_or("")));
  const auto line = [&text](std::string_view name, std::string_view content) {
    text += fmt::format("  {:<10}{}\n", name, content);
  };
  const auto datum = [&](std::string_view name, const std::optional<std::vector<std::byte>>& bytes) {
    if (bytes) line(name, soe_value_text(*bytes, attribute));
  };
  datum("value", parameter.value);
  if (parameter.unit) line("unit", ecat_master::printable(*parameter.unit));
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
  auto line = fmt::format("{}  {:<34}{}", idn_text(idn), ecat_master::printable(parameter.name.value_or("")), value);
  if (parameter.unit) line += " " + ecat_master::printable(*parameter.unit);
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
