#include "text/input_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

std::uint64_t extract(std::span<const std::byte> inputs, std::size_t first, unsigned bits) {
  std::uint64_t value = 0;
  for (unsigned bit = 0; bit < bits; ++bit) {
    const auto at = first + bit;
    value |= (std::to_integer<std::uint64_t>(inputs[at / 8]) >> (at % 8) & 1U) << bit;
  }
  return value;
}

}  // namespace

std::vector<InputValue> read_inputs(const ecat_master::ProcessVariables& variables, std::span<const std::byte> inputs) {
  constexpr unsigned kMostBits = 64;
  std::vector<InputValue> values;
  for (const auto& variable : variables.all()) {
    if (variable.output) continue;
    InputValue input{variables.full_name(variable), variable.index, variable.subindex, variable.bits, std::nullopt};
    const bool readable = variable.bits <= kMostBits && variable.bit_offset + variable.bits <= 8 * inputs.size();
    if (readable) input.value = extract(inputs, variable.bit_offset, variable.bits);
    values.push_back(std::move(input));
  }
  return values;
}

std::string to_text(std::span<const InputValue> inputs) {
  std::size_t width = 0;
  for (const auto& input : inputs) width = std::max(width, input.name.size());
  std::string text;
  for (const auto& input : inputs) {
    text +=
        fmt::format("  {:<{}}  {:04X}h:{:02X}  {:>3} bit", input.name, width, input.index, input.subindex, input.bits);
    text += input.value ? fmt::format("  0x{:0{}X} {}\n", *input.value, (input.bits + 3) / 4, *input.value) : "\n";
  }
  return text;
}

nlohmann::json to_json(std::span<const InputValue> inputs) {
  auto rows = nlohmann::json::array();
  for (const auto& input : inputs) {
    rows.push_back({{"name", input.name},
                    {"index", input.index},
                    {"subindex", input.subindex},
                    {"bits", input.bits},
                    {"value", input.value ? nlohmann::json(*input.value) : nlohmann::json()}});
  }
  return rows;
}

}  // namespace driveline::cli
