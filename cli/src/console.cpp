#include "console.hpp"

#include <cerrno>
#include <cstdio>

#include "text/visible_text.hpp"

namespace driveline::cli {
namespace {

int stdout_error = 0;  ///< the first of stdout

// No fmt::print, which throws when the file is closed.
bool write_console(std::FILE* file, std::string_view text) noexcept {
  return std::fwrite(text.data(), 1, text.size(), file) == text.size();
}

}  // namespace

void print_line(std::string_view text) noexcept {
  write_console(stderr, visible_text(text) + '\n');
}

void print_text(std::string_view text) noexcept {
  if (!write_console(stdout, visible_text(text)) && stdout_error == 0) stdout_error = errno;
}

int finish_output() noexcept {
  if (std::fflush(stdout) != 0 && stdout_error == 0) stdout_error = errno;
  if (std::ferror(stdout) != 0 && stdout_error == 0) stdout_error = EIO;
  return stdout_error;
}

}  // namespace driveline::cli
