#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "commands/commands.hpp"
#include "commands/completion.hpp"
#include "console.hpp"

namespace driveline::cli {
namespace {

std::string joined(const std::vector<std::string>& words, std::string_view separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// Splits "-p,--position" into its names.
std::vector<std::string> names_of(const Argument& argument) {
  std::vector<std::string> names;
  std::string_view rest = argument.names;
  while (!rest.empty()) {
    const auto comma = std::min(rest.find(','), rest.size());
    names.emplace_back(rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return names;
}

/// The bash command that offers candidates for a value.
std::string offer(const Value& value) {
  switch (value.kind) {
    case Value::Kind::kFile:
      return "_driveline_paths -f";
    case Value::Kind::kFolder:
      return "_driveline_paths -d";
    case Value::Kind::kInterface:
      return "_driveline_words \"$(cd /sys/class/net && echo *)\"";
    case Value::Kind::kChoice:
      return fmt::format("_driveline_words \"{}\"", fmt::join(value.choices, " "));
    case Value::Kind::kText:
    case Value::Kind::kNone:
      break;
  }
  return ":";  // no candidates
}

/// The case branch of a command: values of its options, then its options, then its positional arguments.
std::string branch(std::string_view name, const Command& command) {
  Arguments arguments;
  const auto unused = command.prepare(arguments);
  std::string values;
  std::vector<std::string> options = {"--help"};
  std::string position;
  for (const auto& argument : arguments.list()) {
    if (argument.positional()) {
      if (argument.value.kind != Value::Kind::kText) position += fmt::format("      {}\n", offer(argument.value));
      continue;
    }
    const auto names = names_of(argument);
    options.insert(options.end(), names.begin(), names.end());
    if (argument.value.kind != Value::Kind::kNone) {
      values += fmt::format("        {}) {}; return ;;\n", joined(names, " | "), offer(argument.value));
    }
  }
  std::string text = fmt::format("    \"{}\")\n", name);
  if (!values.empty()) text += fmt::format("      case $previous in\n{}      esac\n", values);
  text +=
      fmt::format("      if [[ $current == -* ]]; then _driveline_words \"{}\"; return; fi\n", joined(options, " "));
  return text + position + "      ;;\n";
}

/// First words of the command line, and the second words of each group.
struct Words {
  std::vector<std::string> first = {"--help", "--version"};
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;
};

Words collect_words() {
  Words words;
  for (const auto& command : commands()) {
    const auto space = command.name.find(' ');
    if (space == std::string_view::npos) {
      words.first.emplace_back(command.name);
      if (command.prepare == nullptr) words.groups.push_back({std::string(command.name), {"--help"}});
    } else {
      words.groups.back().second.emplace_back(command.name.substr(space + 1));
    }
    if (!command.also.empty()) words.first.emplace_back(command.also);
  }
  return words;
}

}  // namespace

std::string bash_completion() {
  const auto words = collect_words();
  std::string text =
      "# Completion of driveline for bash, made by `driveline completion bash`.\n"
      "_driveline_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$current\"); }\n"
      "_driveline_paths() {\n"
      "  compopt -o filenames 2>/dev/null\n"
      "  mapfile -t COMPREPLY < <(compgen \"$1\" -- \"$current\")\n"
      "}\n"
      "_driveline() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
      "  COMPREPLY=()\n";
  text += fmt::format("  if ((COMP_CWORD == 1)); then _driveline_words \"{}\"; return; fi\n", joined(words.first, " "));
  text += "  case $command in\n";
  for (const auto& [group, members] : words.groups) {
    text += fmt::format("    {}) if ((COMP_CWORD == 2)); then _driveline_words \"{}\"; return; fi\n", group,
                        joined(members, " "));
    text += "      command+=\" ${COMP_WORDS[2]}\" ;;\n";
  }
  text += "  esac\n  case $command in\n";
  for (const auto& command : commands()) {
    if (command.prepare == nullptr) continue;
    text += branch(command.name, command);
    if (!command.also.empty()) text += branch(command.also, command);
  }
  return text + "  esac\n}\ncomplete -F _driveline driveline\n";
}

namespace {

/// Escapes a text for single quotes of zsh inside the brackets of _arguments.
std::string zsh_text(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'') {
      safe += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':') safe += '\\';
      safe += c;
    }
  }
  return safe;
}

/// The action of _arguments that completes a value.
std::string zsh_action(const Value& value) {
  switch (value.kind) {
    case Value::Kind::kFile:
      return "_files";
    case Value::Kind::kFolder:
      return "_files -/";
    case Value::Kind::kInterface:
      return "_net_interfaces";
    case Value::Kind::kChoice:
      return fmt::format("({})", fmt::join(value.choices, " "));
    case Value::Kind::kText:
    case Value::Kind::kNone:
      break;
  }
  return " ";
}

/// The specifications of an argument for _arguments: one per name, each excluding the others.
std::string zsh_specs(const Argument& argument) {
  const auto value = argument.value.kind == Value::Kind::kNone
                         ? std::string()
                         : fmt::format(":{}:{}", zsh_text(argument.value.name), zsh_action(argument.value));
  if (argument.positional()) {
    const bool many = std::holds_alternative<std::vector<std::string>*>(argument.target);
    return fmt::format(" \\\n        '{}:{}:{}'",
                       many                ? "*"
                       : argument.required ? ""
                                           : ":",
                       zsh_text(argument.value.name), zsh_action(argument.value));
  }
  const auto names = names_of(argument);
  std::string text;
  for (const auto& name : names) {
    text += fmt::format(" \\\n        '({}){}[{}]{}'", joined(names, " "), name, zsh_text(argument.help), value);
  }
  return text;
}

std::string zsh_branch(std::string_view name, const Command& command) {
  Arguments arguments;
  const auto unused = command.prepare(arguments);
  std::string text = fmt::format("    '{}')\n      _arguments '--help[Options and examples]'", name);
  for (const auto& argument : arguments.list()) text += zsh_specs(argument);
  return text + " ;;\n";
}

/// "name:summary" of the commands of `group`, or of all first words if it is empty.
std::string zsh_commands(std::string_view group) {
  std::string text;
  for (const auto& command : commands()) {
    const auto space = command.name.find(' ');
    const bool member = space != std::string_view::npos && command.name.substr(0, space) == group;
    const auto summary = zsh_text(command.summary);
    if (member) text += fmt::format(" '{}:{}'", command.name.substr(space + 1), summary);
    if (group.empty() && space == std::string_view::npos) text += fmt::format(" '{}:{}'", command.name, summary);
    if (group.empty() && !command.also.empty()) text += fmt::format(" '{}:{}'", command.also, summary);
  }
  return text;
}

}  // namespace

std::string zsh_completion() {
  std::string text =
      "#compdef driveline\n"
      "# Completion of driveline for zsh, made by `driveline completion zsh`.\n"
      "_driveline() {\n"
      "  local -a words_here\n"
      "  if ((CURRENT == 2)); then\n";
  text += fmt::format("    words_here=({} '--help' '--version')\n    _describe command words_here\n    return\n  fi\n",
                      zsh_commands(""));
  text += "  local command=$words[2]\n  case $command in\n";
  for (const auto& command : commands()) {
    if (command.prepare != nullptr) continue;
    text += fmt::format(
        "    {})\n      if ((CURRENT == 3)); then words_here=({} '--help'); _describe command words_here; return; fi\n"
        "      command+=\" $words[3]\"\n      shift words\n      ((CURRENT--)) ;;\n",
        command.name, zsh_commands(command.name));
  }
  text += "  esac\n  shift words\n  ((CURRENT--))\n  case $command in\n";
  for (const auto& command : commands()) {
    if (command.prepare == nullptr) continue;
    text += zsh_branch(command.name, command);
    if (!command.also.empty()) text += zsh_branch(command.also, command);
  }
  return text +
         "  esac\n}\n"
         "if [[ $funcstack[1] == _driveline ]]; then _driveline \"$@\"; else compdef _driveline driveline; fi\n";
}

Execute prepare_completion(Arguments& to) {
  auto shell = std::make_shared<std::string>();
  to.required(shell.get(), Value::choice("SHELL", {"bash", "zsh"}), "bash or zsh");
  return [shell]() -> Outcome<int> {
    if (*shell != "bash" && *shell != "zsh") {
      return misused(fmt::format("shell \"{}\": bash or zsh is expected", *shell));
    }
    print_out("{}", *shell == "bash" ? bash_completion() : zsh_completion());
    return 0;
  };
}

}  // namespace driveline::cli
