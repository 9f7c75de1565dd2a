#pragma once

#include <fmt/format.h>
#include <cstdint>
#include <string_view>

#include "driveline/runtime/observer.hpp"

namespace driveline::cli {

/// Severity of a line on stderr, in the numbers of syslog(3).
enum class LogLevel : std::uint8_t { kError = 3, kNotice = 5, kInformation = 6 };

/// Prints one line for the user on stderr. Never fails, because the program must not depend on a reader of stderr.
/// Control sequences are made visible: texts come from files and slaves. When stderr is the journal, each line starts
/// with its severity (sd-daemon(3)).
void print_line(std::string_view text, LogLevel level = LogLevel::kInformation) noexcept;

/// Prints text for the user on stdout, with control sequences made visible.
void print_text(std::string_view text) noexcept;
/// Flushes stdout. Returns the errno of the first write that failed, or 0.
[[nodiscard]] int finish_output() noexcept;

/// Formats the progress of a command and prints it on stderr.
template <typename... Arguments>
void progress(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_line(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// Formats the output of a command and prints it on stdout.
template <typename... Arguments>
void print_out(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_text(fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// Prints the events of a line on stderr.
class ConsoleObserver : public runtime::Observer {
 public:
  /// `increments`: also prints lengths in drive increments.
  explicit ConsoleObserver(bool increments = false) noexcept : increments_(increments) {}
  void event(const runtime::Event& event) override;

 private:
  bool increments_;
};

}  // namespace driveline::cli
