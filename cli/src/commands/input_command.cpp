#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"

namespace driveline::cli {
namespace {

struct InputOptions {
  std::string control;             ///< socket of `simulate` or `run`
  std::string config;              ///< description of the running line
  std::vector<std::string> words;  ///< slave, then settings
};

Outcome<int> input(const InputOptions& options) {
  const auto path = find_control(options.control, options.config);
  if (!path) return tl::unexpected(path.error());
  return order_simulation(*path, fmt::format("input {}", fmt::join(options.words, " ")),
                          options.control.empty() ? "run" : "simulate");
}

}  // namespace

Execute prepare_input(Arguments& to) {
  auto options = std::make_shared<InputOptions>();
  to.option("--config", &options->config, Value::file(), "Line description of the running line");
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket of `simulate --control` or of a `run`; default: that of the only line that runs");
  to.required(&options->words, Value::text("SLAVE"),
              "Name or position of the slave, and inputs to set: INPUT=VALUE ...; without inputs all are shown");
  return [options] { return input(*options); };
}

}  // namespace driveline::cli
