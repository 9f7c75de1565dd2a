#include "program.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <deque>
#include <sstream>
#include <string_view>
#include <vector>

#include "commands/command.hpp"
#include "console.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "process_limits.hpp"
#include "program_version.hpp"

namespace driveline::cli {
namespace {

/// The command with its groups: "driveline esi show".
std::string full_name(const CLI::App* app) {
  return app->get_parent() == nullptr ? app->get_name() : full_name(app->get_parent()) + " " + app->get_name();
}

/// The first word on the command line that the parser does not expect.
std::string unexpected(const CLI::App* app, const std::vector<std::string>& words) {
  // The value after an unknown option is unexpected as well: name the option.
  const auto option = std::find_if(words.begin(), words.end(), [](const auto& word) { return word.starts_with('-'); });
  const auto& word = option == words.end() ? words.front() : *option;
  std::vector<std::string> known;
  if (word.starts_with('-')) {
    for (const auto* each : app->get_options()) {
      for (const auto& name : each->get_lnames()) known.push_back("--" + name);
    }
  } else {
    for (const auto* each : app->get_subcommands({})) known.push_back(each->get_name());
  }
  const auto meant = runtime::closest(word, std::vector<std::string_view>(known.begin(), known.end()));
  const auto hint = meant.empty() ? std::string{} : fmt::format("; did you mean {}?", meant);
  if (word.starts_with('-')) return fmt::format("there is no option {}{}", word, hint);
  if (!known.empty()) return fmt::format("there is no command {}{}", word, hint);
  const bool takes_file = app->get_option_no_throw("--config") != nullptr && word.ends_with(".toml");
  return fmt::format("{} was not expected{}", word, takes_file ? "; a line description is given as --config FILE" : "");
}

std::string what_is_wrong(const CLI::App* program, const CLI::App* app, const CLI::Error& error) {
  std::string sentence = error.what();
  // CLI11 reports a missing command of a group before it reports an unknown word at that position: name the word.
  const bool no_command =
      dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && app->get_require_subcommand_min() > 0;
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr || no_command) {
    if (const auto words = program->remaining(true); !words.empty()) return unexpected(app, words);
  }
  // CLI11 writes "--duration: 1 required TEXT missing".
  const auto colon = sentence.find(": 1 required ");
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && colon != std::string::npos) {
    return sentence.substr(0, colon) + " needs a value";
  }
  return sentence;
}

/// One sentence for any parse error, in the style of the commands' failures.
std::string failure_message(const CLI::App* program, const CLI::Error& error) {
  const auto* app = program;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
  return fmt::format("{}: {}; {} --help shows more\n", full_name(app), what_is_wrong(program, app, error),
                     full_name(app));
}

void declare(CLI::App& app, const Argument& argument) {
  const std::string names(argument.names);
  const std::string help(argument.help);
  auto* option = std::visit(
      [&](auto* target) -> CLI::Option* {
        if constexpr (std::is_same_v<decltype(target), bool*>) {
          return app.add_flag(names, *target, help);
        } else {
          return app.add_option(names, *target, help);
        }
      },
      argument.target);
  if (argument.value.kind != Value::Kind::kNone && !argument.positional()) {
    option->option_text(std::string(argument.value.name));
  } else if (argument.positional()) {
    option->option_text(argument.required ? " " : "(optional)");
  }
  if (argument.required) option->required();
  // A repeatable option takes one value each time; the next word does not belong to it.
  if (!argument.positional()) option->allow_extra_args(false);
}

/// The examples as typed, with `name` as the name of the command.
std::string example_lines(const Command& command, std::string_view name) {
  std::string text = command.examples.empty() ? "" : "Examples:";
  std::string_view rest = command.examples;
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    text += fmt::format("\n  driveline {}{}", name, rest.substr(command.name.size(), end - command.name.size()));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return text;
}

/// A command with its parser.
struct Built {
  CLI::App* app = nullptr;
  Arguments arguments;
  Execute execute;
};

/// `name`: the name that users type, either the command's own or its second one.
void add_command(CLI::App& parent, const Command& command, std::string_view name, std::string_view group,
                 std::deque<Built>& built) {
  const auto last_word = name.substr(name.find(' ') + 1);
  auto* app = parent.add_subcommand(std::string(last_word), std::string(command.summary));
  app->group(std::string(group));
  app->footer(example_lines(command, name));
  if (command.prepare == nullptr) {
    app->require_subcommand(1);
    return;
  }
  auto& entry = built.emplace_back();
  entry.app = app;
  entry.execute = command.prepare(entry.arguments);
  for (const auto& argument : entry.arguments.list()) declare(*app, argument);
}

void add_commands(CLI::App& program, std::deque<Built>& built) {
  for (const auto& command : commands()) {
    const auto space = command.name.find(' ');
    if (space == std::string_view::npos) {
      add_command(program, command, command.name, command.group, built);
    } else {
      auto* head = program.get_subcommand(std::string(command.name.substr(0, space)));
      add_command(*head, command, command.name, "Commands", built);
    }
    if (!command.also.empty()) add_command(program, command, command.also, "Other names", built);
  }
}

/// Flushes stdout; exit status 1 when that fails.
int finish_printing() {
  const int error = finish_output();
  if (error == 0) return 0;
  progress("driveline: the output cannot be written: {}", std::strerror(error));
  return 1;
}

int execute_command(const Built& command) {
  const auto outcome = command.execute();
  if (const int status = finish_printing(); status != 0) return status;
  if (outcome) return *outcome;
  print_line(fmt::format("{}: {}", full_name(command.app), outcome.error().text), LogLevel::kError);
  return outcome.error().status;
}

/// Prints help and version on stdout, and complaints about the command line on stderr. A complaint quotes arbitrary
/// words.
int tell_parse_outcome(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out;
  std::ostringstream complaint;
  const bool fine = app.exit(error, out, complaint) == 0;
  print_text(out.str());
  auto sentence = complaint.str();
  if (sentence.ends_with('\n')) sentence.pop_back();
  if (!sentence.empty()) print_line(sentence);
  return fine ? finish_printing() : 2;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  rt::refuse_long_files_with_errors();
  for (auto* const check : {too_little_stack, extend_stack}) {
    if (const auto problem = check(); !problem.empty()) {
      progress("driveline: {}", problem);
      return 1;
    }
  }
  CLI::App app{"A real-time EtherCAT master for servo drive lines, and the drives to run it against", "driveline"};
  app.failure_message(failure_message);
  app.set_version_flag("--version", std::string(program_version()));
  app.footer("driveline COMMAND --help shows the options of a command with examples.");
  // At most one command: words after a command are its arguments, even the name of another command (`bench dc`).
  app.require_subcommand(0, 1);
  std::deque<Built> built;
  add_commands(app, built);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return tell_parse_outcome(app, error);
  }
  for (const auto& command : built) {
    if (command.app->parsed()) return execute_command(command);
  }
  progress("driveline: a command is missing; driveline --help lists the commands");
  return 2;
}

}  // namespace driveline::cli
