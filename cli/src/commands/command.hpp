#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "failure.hpp"

namespace driveline::cli {

/// A value on the command line: its name in the help, and the source of its completions.
struct Value {
  enum class Kind : std::uint8_t { kNone, kText, kFile, kFolder, kInterface, kChoice };
  Kind kind = Kind::kNone;
  std::string_view name;
  std::vector<std::string_view> choices;  ///< kChoice only

  static Value text(std::string_view name) { return {Kind::kText, name, {}}; }
  static Value file(std::string_view name = "FILE") { return {Kind::kFile, name, {}}; }
  static Value folder(std::string_view name = "FOLDER") { return {Kind::kFolder, name, {}}; }
  static Value interface() { return {Kind::kInterface, "NAME", {}}; }
  static Value choice(std::string_view name, std::vector<std::string_view> choices) {
    return {Kind::kChoice, name, std::move(choices)};
  }
};

/// Where a value is stored. An optional stays empty if the value is not given; a vector takes all values that follow.
using Target = std::variant<bool*, std::string*, std::optional<std::string>*, std::vector<std::string>*>;

/// An option, a flag (value kind none), or a positional argument (names without a dash).
struct Argument {
  std::string_view names;  ///< "-p,--position" or "INDEX"
  std::string_view help;
  Value value;
  Target target;
  bool required = false;

  [[nodiscard]] bool positional() const noexcept { return !names.starts_with('-'); }
};

/// The arguments of a command, in the order of its help.
class Arguments {
 public:
  void flag(std::string_view names, bool& target, std::string_view help) {
    list_.push_back({names, help, {}, &target, false});
  }
  void option(std::string_view names, Target target, Value value, std::string_view help) {
    list_.push_back({names, help, std::move(value), target, false});
  }
  void positional(Target target, Value value, std::string_view help) { add_positional(target, value, help, false); }
  void required(Target target, Value value, std::string_view help) { add_positional(target, value, help, true); }

  [[nodiscard]] std::span<const Argument> list() const noexcept { return list_; }

 private:
  void add_positional(Target target, Value& value, std::string_view help, bool required) {
    const auto name = value.name;
    list_.push_back({name, help, std::move(value), target, required});
  }
  std::vector<Argument> list_;
};

/// Runs a command after its arguments have been filled in: exit status 0, or a Failure.
using Execute = std::function<Outcome<int>()>;

/// One row of the table of commands. Help, parsing and shell completion come from it and from the arguments that
/// `prepare` declares.
struct Command {
  std::string_view name;   ///< "run"; for a command of a group "esi show"
  std::string_view also;   ///< a second name, from the IgH tool; empty: none
  std::string_view group;  ///< heading in the help
  std::string_view summary;
  std::string_view examples;          ///< command lines without the name of the program, one per line
  Execute (*prepare)(Arguments& to);  ///< declares the arguments; null: the head of a group of commands
};

/// All commands, in the order of the help; the head of a group precedes its commands.
[[nodiscard]] std::span<const Command> commands();

}  // namespace driveline::cli
