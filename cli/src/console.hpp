#pragma once

#include <fmt/format.h>
#include <string_view>

#include "driveline/runtime/observer.hpp"

namespace driveline::cli {

/// One line for the user on stderr. Never fails, because the line must not depend on a reader. Control sequences are
/// made visible: texts come from files and slaves.
void print_line(std::string_view text) noexcept;

/// Text for the user on stdout, control sequences made visible.
void print_text(std::string_view text) noexcept;
/// Flushes stdout; the errno of the first write that failed, or 0.
[[nodiscard]] int finish_output() noexcept;

/// Progress of a command, formatted.
template <typename... Arguments>
void progress(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_line(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// Output of a command, formatted, on stdout.
template <typename... Arguments>
void print_out(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_text(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// Prints what happens to a line on stderr.
class ConsoleObserver : public runtime::Observer {
 public:
  /// `increments`: lengths in drive increments, too.
  explicit ConsoleObserver(bool increments = false) noexcept : increments_(increments) {}
  void event(const runtime::Event& event) override {
    progress("{}{}", event.is_fault() ? "fault: " : "", runtime::describe(event, increments_));
  }

 private:
  bool increments_;
};

}  // namespace driveline::cli
