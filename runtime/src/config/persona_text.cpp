#include "driveline/runtime/config/persona_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <vector>

#include "driveline/runtime/config/finite_number.hpp"
#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::runtime {
namespace {

using slaves::kPersonas;
using slaves::PersonaRow;
using slaves::PersonaValue;

std::string unknown_name(std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& row : kPersonas) names.push_back(row.name);
  const auto similar = closest(name, names);
  return fmt::format("\"{}\" is not a persona; the personas are {}{}", name, fmt::join(names, ", "),
                     similar.empty() ? "" : fmt::format("; did you mean \"{}\"?", similar));
}

std::string number_text(const PersonaValue& value, std::uint32_t number) {
  return value.hexadecimal ? fmt::format("0x{:04X}", number) : std::to_string(number);
}

/// Returns the limits of the value: "1 to 60000 (ms)".
std::string limits_text(const PersonaValue& value) {
  return fmt::format("{} to {} ({})", number_text(value, value.lowest), number_text(value, value.highest),
                     value.meaning);
}

Result<slaves::Persona> with_value(const PersonaRow& row, std::string_view text) {
  if (row.value.meaning.empty())
    return fail(ErrorKind::kSetting, fmt::format("\"{}\" has no value, \"={}\" is given", row.name, text));
  const auto number = whole_number(text);
  if (!number || *number < row.value.lowest || *number > row.value.highest) {
    return fail(ErrorKind::kSetting,
                fmt::format("the value of \"{}\" is \"{}\", {} is expected", row.name, text, limits_text(row.value)));
  }
  return slaves::Persona{row.kind, static_cast<std::uint32_t>(*number)};
}

}  // namespace

Result<slaves::Persona> parse_persona(std::string_view text) {
  const auto equals = text.find('=');
  const auto name = text.substr(0, equals);
  const auto row = std::find_if(kPersonas.begin(), kPersonas.end(), [name](const auto& r) { return r.name == name; });
  if (row == kPersonas.end()) return fail(ErrorKind::kSetting, unknown_name(name));
  if (equals == std::string_view::npos) return slaves::Persona{row->kind, row->value.standard};
  return with_value(*row, text.substr(equals + 1));
}

std::string persona_help() {
  std::string text =
      "Personas: quirks of real drives for a simulated slave, persona = [\"NAME\", \"NAME=VALUE\", ...] in its\n"
      "[[slave]]. docs/real_drives.md says what `driveline run` does with each.\n";
  for (const auto& row : kPersonas) {
    text += fmt::format("  {}\n    {}\n", row.name, row.text);
    if (!row.value.meaning.empty()) {
      text += fmt::format("    value: {}; default {}\n", limits_text(row.value),
                          number_text(row.value, row.value.standard));
    }
    text += fmt::format("    source: {}\n", row.source);
  }
  return text;
}

}  // namespace driveline::runtime
