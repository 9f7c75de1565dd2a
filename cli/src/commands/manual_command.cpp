#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "program_version.hpp"

namespace driveline::cli {
namespace {

struct ManualOptions {
  std::vector<std::string> words;
  std::optional<std::string> output;
};

/// Escapes a text for roff: hyphens stay copyable, and no line starts a request by accident.
std::string roff(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\\') {
      safe += "\\e";
    } else if (c == '-') {
      safe += "\\-";
    } else if ((c == '.' || c == '\'') && (safe.empty() || safe.back() == '\n')) {
      safe += "\\&";
      safe += c;
    } else {
      safe += c;
    }
  }
  return safe;
}

/// The name of the page: "driveline-esi-show".
std::string page_name(const Command* command) {
  std::string name = "driveline";
  if (command == nullptr) return name;
  name += "-" + std::string(command->name);
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string head(const std::string& name, std::string_view summary) {
  return fmt::format(
      ".\\\" Made by `driveline manual`.\n.TH {} 1 \"\" \"driveline {}\" \"driveline\"\n.SH NAME\n{} \\- {}\n",
      roff(name), program_release(), roff(name), roff(summary));
}

std::string synopsis(const Command& command, const Arguments& arguments) {
  std::string text = fmt::format(".SH SYNOPSIS\n.B driveline {}\n", roff(command.name));
  if (command.prepare == nullptr) return text + ".I COMMAND\n";
  bool options = false;
  for (const auto& argument : arguments.list()) options = options || !argument.positional();
  if (options) text += "[\\fIOPTIONS\\fR]\n";
  for (const auto& argument : arguments.list()) {
    if (!argument.positional()) continue;
    const bool many = std::holds_alternative<std::vector<std::string>*>(argument.target);
    const auto word = fmt::format("\\fI{}\\fR{}", roff(argument.names), many ? " ..." : "");
    text += argument.required ? word + "\n" : fmt::format("[{}]\n", word);
  }
  return text;
}

/// The entry of an option or argument, with its value.
std::string entry(const Argument& argument) {
  std::string names = roff(argument.names);
  if (const auto comma = names.find(','); comma != std::string::npos) names.replace(comma, 1, "\\fR, \\fB");
  std::string text = fmt::format(".TP\n\\fB{}\\fR", names);
  if (!argument.positional() && argument.value.kind != Value::Kind::kNone) {
    text += fmt::format(" \\fI{}\\fR", roff(argument.value.name));
  }
  text += fmt::format("\n{}{}\n", roff(argument.help), argument.help.ends_with('.') ? "" : ".");
  if (argument.value.kind != Value::Kind::kChoice) return text;
  std::string choices;
  for (const auto& choice : argument.value.choices) choices += (choices.empty() ? "" : ", ") + roff(choice);
  return text + fmt::format("One of: {}.\n", choices);
}

std::string examples(const Command& command) {
  if (command.examples.empty()) return {};
  std::string text = ".SH EXAMPLES\n.nf\n";
  std::string_view rest = command.examples;
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    text += fmt::format("driveline {}\n", roff(rest.substr(0, end)));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return text + ".fi\n";
}

/// The commands of a group, or those with a single word.
std::string list_of_commands(std::string_view group) {
  std::string text = ".SH COMMANDS\n";
  for (const auto& command : commands()) {
    const auto space = command.name.find(' ');
    const bool member = group.empty() ? space == std::string_view::npos
                                      : space != std::string_view::npos && command.name.substr(0, space) == group;
    if (!member) continue;
    text += fmt::format(".TP\n\\fB{}\\fR(1)\n{}\n", roff(page_name(&command)), roff(command.summary));
  }
  return text;
}

constexpr std::string_view kExitStatus =
    ".SH EXIT STATUS\n"
    ".TP\n0\nSuccess; also after a signal that ended the command normally.\n"
    ".TP\n1\nThe operation failed; the reason is the last line on standard error.\n"
    ".TP\n2\nThe command line, the line description or the path is wrong; nothing was opened.\n"
    ".TP\n3\n\\fBdriveline scan \\-\\-config\\fR: the line differs from its description.\n";

std::string page_of_program() {
  auto text =
      head(page_name(nullptr), "real-time EtherCAT master for servo drive lines, and the drives to run it against");
  text += ".SH SYNOPSIS\n.B driveline\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n";
  text +=
      ".SH DESCRIPTION\nRuns a line of EtherCAT servo drives from a line description: states, mailbox, distributed "
      "clocks,\n"
      "process data every 125 us, setpoints. The same program simulates the drives, in its process or served on a "
      "network\n"
      "interface to any master. Each command has a page of its own.\n";
  text += list_of_commands("");
  text += kExitStatus;
  text +=
      ".SH FILES\n.TP\n\\fI/etc/driveline/NAME.toml\\fR\nThe line description of the service \\fBdriveline@NAME\\fR.\n"
      ".TP\n\\fI/run/driveline\\fR, \\fI$XDG_RUNTIME_DIR/driveline\\fR\nSockets at which running lines accept "
      "requests.\n";
  return text;
}

std::string page_of(const Command& command) {
  Arguments arguments;
  if (command.prepare != nullptr) static_cast<void>(command.prepare(arguments));
  auto text = head(page_name(&command), command.summary) + synopsis(command, arguments);
  text += fmt::format(".SH DESCRIPTION\n{}.\n", roff(command.summary));
  if (!command.also.empty()) text += fmt::format("Also known as \\fBdriveline {}\\fR.\n", roff(command.also));
  if (command.prepare == nullptr) text += list_of_commands(command.name);
  if (!arguments.list().empty()) text += ".SH OPTIONS\n";
  for (const auto& argument : arguments.list()) text += entry(argument);
  return text + examples(command) + std::string(kExitStatus) + ".SH SEE ALSO\n.BR driveline (1)\n";
}

Outcome<void> write_page(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  return outcome(runtime::write_file(folder / (name + ".1"), text));
}

Outcome<int> write_all(const std::filesystem::path& folder) {
  if (auto written = write_page(folder, page_name(nullptr), page_of_program()); !written) {
    return tl::unexpected(written.error());
  }
  for (const auto& command : commands()) {
    if (auto written = write_page(folder, page_name(&command), page_of(command)); !written) {
      return tl::unexpected(written.error());
    }
  }
  return 0;
}

Outcome<int> print_manual(const ManualOptions& options) {
  if (options.output) {
    if (!options.words.empty()) return misused("--output writes the pages of all commands: give no command");
    return write_all(*options.output);
  }
  if (options.words.empty()) {
    print_out("{}", page_of_program());
    return 0;
  }
  const auto name = fmt::format("{}", fmt::join(options.words, " "));
  for (const auto& command : commands()) {
    if (command.name != name && (command.also.empty() || command.also != name)) continue;
    print_out("{}", page_of(command));
    return 0;
  }
  return misused(fmt::format("there is no command \"{}\"; driveline --help lists the commands", name));
}

}  // namespace

Execute prepare_manual(Arguments& to) {
  auto options = std::make_shared<ManualOptions>();
  to.positional(&options->words, Value::text("COMMAND"),
                "Command whose page is printed, e.g. esi show; without it, that of driveline");
  to.option("--output", &options->output, Value::folder(), "Write the pages of all commands into this folder");
  return [options] { return print_manual(*options); };
}

}  // namespace driveline::cli
