#include "text/input_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace driveline::cli {
std::string to_text(std::span<const runtime::InputValue> inputs) {
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

nlohmann::json to_json(std::span<const runtime::InputValue> inputs) {
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
