// driveline-dds: shows and records a line over DDS. A separate program, so that code that reads network packets stays
// out of the process that runs the line, and out of the program that starts this one.

#include <fmt/format.h>

#include <cstdio>

#include "client.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "text.hpp"

namespace {

using namespace driveline::bridge::clients;

struct Command {
  std::string_view name;
  Outcome<int> (*execute)(const Options& options);
};

constexpr Command kCommands[] = {{"echo", echo}, {"plot", plot}, {"record", record}, {"top", top}};

Outcome<int> execute(const Options& options) {
  for (const auto& command : kCommands) {
    if (command.name == options.command) return command.execute(options);
  }
  return misused("there is no such command");
}

int tell(const Failure& failure, const std::string& command) {
  fmt::print(stderr, "driveline {}: {}\n", visible(command), visible(failure.text));
  return failure.status;
}

}  // namespace

int main(int argc, char** argv) {
  const auto options = read_options(argc - 1, argv + 1);
  const std::string command = argc > 1 ? argv[1] : "dds";
  if (command == "--help" || (options && options->help)) {
    std::fputs(kHelp, stdout);
    return 0;
  }
  if (!options) return tell(options.error(), command);
  driveline::rt::catch_stop_signals();
  driveline::rt::refuse_long_files_with_errors();
  const auto status = execute(*options);
  return status ? *status : tell(status.error(), command);
}
