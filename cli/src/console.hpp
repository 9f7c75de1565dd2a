#pragma once

#include <fmt/format.h>
#include <string_view>

namespace driveline::cli {

/// One line for the user on stderr. Never fails: whether somebody reads it is nothing the line depends on.
void print_line(std::string_view text) noexcept;

/// Progress of a command, formatted.
template <typename... Arguments>
void progress(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  print_line(fmt::format(text, std::forward<Arguments>(arguments)...));
}

}  // namespace driveline::cli
