#include "driveline/runtime/record/input_values.hpp"

namespace driveline::runtime {
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
  constexpr unsigned kMaxBits = 64;
  std::vector<InputValue> values;
  for (const auto& variable : variables.all()) {
    if (variable.output) continue;
    InputValue input{variables.full_name(variable), variable.index, variable.subindex, variable.bits, std::nullopt};
    const bool readable = variable.bits <= kMaxBits && variable.bit_offset + variable.bits <= 8 * inputs.size();
    if (readable) input.value = extract(inputs, variable.bit_offset, variable.bits);
    values.push_back(std::move(input));
  }
  return values;
}

}  // namespace driveline::runtime
