#pragma once

#include <fmt/format.h>
#include <string_view>

#include "driveline/runtime/observer.hpp"

namespace driveline::cli {

/// One line for the user on stderr. Never fails: whether somebody reads it is nothing the line depends on. What a
/// terminal would obey is made visible: texts come from files and slaves.
void print_line(std::string_view text) noexcept;

/// Text for the user on stdout, made visible likewise.
void print_text(std::string_view text) noexcept;
/// Writes what is still on its way to stdout; why it or anything before could not be written, as errno has it, or 0.
[[nodiscard]] int finish_output() noexcept;

/// Progress of a command, formatted.
template <typename... Arguments>
void progress(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_line(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// What a command was asked for, formatted, on stdout.
template <typename... Arguments>
void print_out(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_text(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// What happens to a line, as progress on stderr.
class ConsoleObserver : public runtime::Observer {
 public:
  void progress(std::string_view sentence) override { print_line(sentence); }
  void event(std::string_view sentence) override { print_line(sentence); }
  void fault(std::string_view sentence) override { cli::progress("fault: {}", sentence); }
};

}  // namespace driveline::cli
