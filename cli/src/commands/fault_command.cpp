#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "console.hpp"
#include "driveline/runtime/config/can_fault_text.hpp"
#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/config/persona_text.hpp"

namespace driveline::cli {
namespace {

struct FaultOptions {
  std::string control;  ///< socket of `simulate` or `run`
  std::string config;   ///< description of the running line
  std::vector<std::string> words;
};

Outcome<int> fault(const FaultOptions& options) {
  const auto command = fmt::format("{}", fmt::join(options.words, " "));
  if (command == "help") {
    print_out("{}\n{}", runtime::fault_help(), runtime::can_fault_help());
    return 0;
  }
  if (command == "personas") {
    print_out("{}", runtime::persona_help());
    return 0;
  }
  const auto path = find_control(options.control, options.config);
  if (!path) return tl::unexpected(path.error());
  return order_simulation(*path, "fault " + command, options.control.empty() ? "run" : "simulate");
}

}  // namespace

Execute prepare_fault(Arguments& to) {
  auto options = std::make_shared<FaultOptions>();
  to.option("--config", &options->config, Value::file(), "Line description of the running line");
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket of `simulate --control` or of a `run`; default: that of the only line that runs");
  to.required(
      &options->words, Value::text("COMMAND"),
      "KIND KEY=VALUE ..., heal KIND KEY=VALUE ..., heal all, list, states, quit; help lists the kinds, personas "
      "the quirks of real drives");
  return [options] { return fault(*options); };
}

}  // namespace driveline::cli
