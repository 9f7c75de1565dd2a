#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>

#include "commands.hpp"
#include "console.hpp"

namespace {

using namespace driveline::cli;

void add_bus_options(CLI::App& command, BusOptions& bus) {
  command.add_option("--config", bus.config, "Line description (TOML)")->option_text("FILE");
  command.add_option("--iface", bus.interface, "Network interface; replaces the simulated line of the file")
      ->option_text("NAME");
}

/// Seconds; CLI11's own range check lets NaN pass.
std::string check_duration(const std::string& text) {
  double seconds = 0.0;
  const bool number = CLI::detail::lexical_cast(text, seconds);
  return number && seconds >= 0.0 && seconds <= 1e7 ? "" : fmt::format("\"{}\": 0 to 10000000 s is expected", text);
}

/// All complaints are one sentence, as those of the commands.
std::string failure_message(const CLI::App* app, const CLI::Error& error) {
  return fmt::format("{}: {}; {} --help tells more\n", app->get_name(), error.what(), app->get_name());
}

/// "driveline esi show"
std::string full_name(const CLI::App* app) {
  return app->get_parent() == nullptr ? app->get_name() : full_name(app->get_parent()) + " " + app->get_name();
}

/// One subcommand and what it does.
struct Command {
  CLI::App* app = nullptr;
  std::function<Outcome<int>()> execute;
};

int run(int argc, char** argv) {
  CLI::App app{"A real-time EtherCAT master for servo drive lines, and the drives to run it against", "driveline"};
  app.failure_message(failure_message);
  app.set_version_flag("--version", DRIVELINE_VERSION);
  BusOptions bus;
  RunOptions run_options;
  ObjectOptions object;
  std::string wanted_state;
  bool json = false;
  std::vector<Command> commands;
  auto add = [&](const char* name, const char* help, std::function<Outcome<int>()> execute) {
    auto* command = app.add_subcommand(name, help);
    add_bus_options(*command, bus);
    commands.push_back({command, std::move(execute)});
    return command;
  };

  auto* run_command =
      add("run", "Take the line to OP and its axes along their path", [&] { return run_line(bus, run_options); });
  run_command
      ->add_option("--duration", run_options.duration_s, "Seconds in operation; default: until the end of the path")
      ->option_text("SECONDS")
      ->check(check_duration);
  run_command->add_flag("--virtual", bus.virtual_time,
                        "Simulated line on virtual time: deterministic, as fast as possible");
  run_command->add_option("--output", run_options.output_directory, "Folder for CSV files and plots")
      ->option_text("FOLDER");
  run_command->add_option("--capture", run_options.capture, "Write all frames to this pcapng file")
      ->option_text("FILE");
  run_command->add_flag("--no-plots", run_options.no_plots, "Leave only the CSV files");
  run_command->add_flag("--no-telemetry", run_options.no_telemetry, "Do not publish over DDS");
  run_command->add_flag("--json", run_options.json, "Print one JSON document");

  add("simulate", "Serve the simulated line on a network interface to any master", [&] { return simulate(bus); });

  add("slaves", "List the slaves on the line", [&] {
    return list_slaves(bus, json);
  })->add_flag("--json", json, "Print one JSON document");

  auto* states_command =
      add("states", "Show the EtherCAT states, or change them", [&] { return states(bus, wanted_state, json); });
  states_command->add_option("STATE", wanted_state, "INIT, PREOP or SAFEOP");
  states_command->add_flag("--json", json, "Print one JSON document");

  auto* upload_command = add("upload", "Read an object over CoE", [&] { return upload(bus, object); });
  auto* download_command = add("download", "Write an object over CoE", [&] { return download(bus, object); });
  for (auto* command : {upload_command, download_command}) {
    command->add_option("-p,--position", object.slave, "Position of the slave, 0 is the first; default: 0")
        ->option_text("N")
        ->check(CLI::Range(0, 65535));
    command->add_option("-t,--type", object.type, "uint8 ... int64, float, double, string; default: raw bytes in hex")
        ->option_text("TYPE");
    command->add_option("INDEX", object.index, "Index, e.g. 0x6041 or 6041h")->required();
    command->add_option("SUBINDEX", object.subindex, "Sub-index")->required();
    command->add_flag("--json", object.json, "Print one JSON document");
  }
  download_command->add_option("VALUE", object.value, "Value")->required();

  auto* esi_command = app.add_subcommand("esi", "Device description files (ESI) and EEPROM images (SII)");
  esi_command->require_subcommand(1);
  std::string esi_path;
  auto add_esi = [&](const char* name, const char* help, const char* argument, std::function<Outcome<int>()> execute) {
    auto* command = esi_command->add_subcommand(name, help);
    command->add_option(argument, esi_path)->required();
    commands.push_back({command, std::move(execute)});
  };
  add_esi("generate", "Write ESI file and SII image of the simulated MSD", "DIRECTORY",
          [&] { return generate_esi(esi_path); });
  add_esi("validate", "Check an ESI file and tell what was passed over", "FILE",
          [&] { return validate_esi(esi_path); });
  add_esi("show", "List the devices of an ESI file", "FILE", [&] { return show_esi(esi_path); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return status == 0 ? 0 : 2;
  }
  for (const auto& command : commands) {
    if (!command.app->parsed()) continue;
    const auto outcome = command.execute();
    if (std::fflush(stdout) != 0) {
      progress("driveline: the output cannot be written: {}", std::strerror(errno));
      return 1;
    }
    if (outcome) return *outcome;
    progress("{}: {}", full_name(command.app), outcome.error().text);
    return outcome.error().status;
  }
  progress("driveline: which command? driveline --help lists them");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    progress("driveline: {}", error.what());
    return 1;
  }
}
