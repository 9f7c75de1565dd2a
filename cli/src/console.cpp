#include "console.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include "text/visible_text.hpp"

namespace driveline::cli {
namespace {

int stdout_error = 0;  ///< errno of the first failed write to stdout; 0: none failed

// fmt::print() throws when the file is closed, so write with fwrite().
bool write_console(std::FILE* file, std::string_view text) noexcept {
  return std::fwrite(text.data(), 1, text.size(), file) == text.size();
}

/// Whether JOURNAL_STREAM (systemd.exec(5)) names the device and inode of stderr.
bool compare_stderr_with_the_journal() noexcept {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat found = {};
  return stream != nullptr && ::fstat(STDERR_FILENO, &found) == 0 &&
         stream == fmt::format("{}:{}", found.st_dev, found.st_ino);
}

bool stderr_is_the_journal() noexcept {
  static const bool kIsTheJournal = compare_stderr_with_the_journal();
  return kIsTheJournal;
}

}  // namespace

void print_line(std::string_view text, LogLevel level) noexcept {
  if (!stderr_is_the_journal()) {
    write_console(stderr, visible_text(text) + '\n');
    return;
  }
  // The journal makes an entry of each line, so each one needs the prefix.
  const auto prefix = fmt::format("<{}>", static_cast<int>(level));
  std::string entries;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    entries += prefix + visible_text(text.substr(0, end)) + '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  write_console(stderr, entries);
}

void print_text(std::string_view text) noexcept {
  if (!write_console(stdout, visible_text(text)) && stdout_error == 0) stdout_error = errno;
}

int finish_output() noexcept {
  if (std::fflush(stdout) != 0 && stdout_error == 0) stdout_error = errno;
  if (std::ferror(stdout) != 0 && stdout_error == 0) stdout_error = EIO;
  return stdout_error;
}

void ConsoleObserver::event(const runtime::Event& event) {
  // Progress is for a user at a terminal; it would flood a journal.
  if (event.is<runtime::events::Progress>() && stderr_is_the_journal()) return;
  const auto level = event.is_fault()                               ? LogLevel::kError
                     : event.severity == runtime::Severity::kNotice ? LogLevel::kNotice
                                                                    : LogLevel::kInformation;
  print_line(fmt::format("{}{}", event.is_fault() ? "fault: " : "", runtime::describe(event, increments_)), level);
}

}  // namespace driveline::cli
