#include "console.hpp"

#include <cstdio>

namespace driveline::cli {

void print_line(std::string_view text) noexcept {
  // No fmt::print, which throws when stderr is closed.
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fputc('\n', stderr);
}

}  // namespace driveline::cli
