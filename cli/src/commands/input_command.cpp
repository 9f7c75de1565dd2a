#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"

namespace driveline::cli {
namespace {

struct InputOptions {
  std::string control;             ///< socket of `simulate`
  std::vector<std::string> words;  ///< slave, then settings
};

Outcome<int> input(const InputOptions& options) {
  if (options.control.empty()) return misused("--control PATH is missing: the socket that `simulate --control` opened");
  return order_simulation(options.control, fmt::format("input {}", fmt::join(options.words, " ")));
}

}  // namespace

Execute prepare_input(Arguments& to) {
  auto options = std::make_shared<InputOptions>();
  to.option("--control", &options->control, Value::file("PATH"), "Socket that `simulate --control` listens at");
  to.required(&options->words, Value::text("SLAVE"),
              "Name or position of the slave, and inputs to set: INPUT=VALUE ...; without inputs all are shown");
  return [options] { return input(*options); };
}

}  // namespace driveline::cli
