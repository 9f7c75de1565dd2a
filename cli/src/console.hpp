#pragma once

#include <fmt/format.h>
#include <cstdint>
#include <string_view>

#include "driveline/runtime/observer.hpp"

namespace driveline::cli {

/// How grave a line on stderr is, in the numbers of syslog(3).
enum class Gravity : std::uint8_t { kError = 3, kNotice = 5, kInformation = 6 };

/// One line for the user on stderr. Never fails, because the line must not depend on a reader. Control sequences are
/// made visible: texts come from files and slaves. Where stderr is the journal, its gravity goes in front
/// (sd-daemon(3)).
void print_line(std::string_view text, Gravity gravity = Gravity::kInformation) noexcept;

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
  void event(const runtime::Event& event) override;

 private:
  bool increments_;
};

}  // namespace driveline::cli
