#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/config/persona_text.hpp"

namespace driveline::cli {
namespace {

struct FaultOptions {
  std::string control;  ///< socket of `simulate`
  std::vector<std::string> words;
};

Outcome<int> fault(const FaultOptions& options) {
  const auto command = fmt::format("{}", fmt::join(options.words, " "));
  if (command == "help") {
    print_out("{}", runtime::fault_help());
    return 0;
  }
  if (command == "personas") {
    print_out("{}", runtime::persona_help());
    return 0;
  }
  if (options.control.empty()) return misused("--control PATH is missing: the socket that `simulate --control` opened");
  return order_simulation(options.control, command);
}

}  // namespace

Execute prepare_fault(Arguments& to) {
  auto options = std::make_shared<FaultOptions>();
  to.option("--control", &options->control, Value::file("PATH"), "Socket that `simulate --control` listens at");
  to.required(
      &options->words, Value::text("COMMAND"),
      "KIND KEY=VALUE ..., heal KIND KEY=VALUE ..., heal all, list, states, quit; help lists the kinds, personas "
      "the quirks of real drives");
  return [options] { return fault(*options); };
}

}  // namespace driveline::cli
