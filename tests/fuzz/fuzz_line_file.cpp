// Line descriptions as the program reads them: a refusal has a reason, an accepted line can be built and run.

#include <string>

#include "fuzz_lines.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {

void test_one_input(std::span<const std::byte> input) {
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  // Beside the examples, so that the named files exist.
  try_line(text, examples() / "input.toml");
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> inputs;
  const auto add = [&inputs](const std::string& text) {
    auto& bytes = inputs.emplace_back();
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  };
  for (const char* name : {"mixed.toml", "process_data.toml", "ring4.toml", "vertical.toml"}) add(example_line(name));
  // Short ones, because a mutation often makes another valid one of them.
  add("[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\n");
  add("[line]\ncycle_us = 1000\n[[slave]]\nname = \"d\"\nesi = \"terminals.xml\"\ndevice = \"DI8\"\n[[slave.input]]\n"
      "entry = \"Channel 1/Input\"\nshape = \"steps\"\nat_ms = [0, 1]\nvalues = [0, 1]\n");
  add("bus.esi = [\"terminals.xml\"]\nline = { name = 'l', cycle_us = 500 }\n[[slave]]\nname = \"m\"\n"
      "esi = \"terminals.xml\"\nproduct_code = 0x440\n[[slave.pdo]]\nindex = 0x1600\n");
  return inputs;
}

}  // namespace driveline::fuzz
