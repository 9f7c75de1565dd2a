#include "terminal.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "text/visible_text.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kOtherScreen = "\x1b[?1049h\x1b[?25l";
constexpr std::string_view kScreenBefore = "\x1b[?25h\x1b[?1049l";
constexpr std::string_view kHome = "\x1b[H";
constexpr std::string_view kClearLine = "\x1b[K";
constexpr std::string_view kClearBelow = "\x1b[J";
constexpr char kCtrlC = '\x03';
constexpr char kEscape = '\x1b';

void put(std::string_view bytes) {
  std::fwrite(bytes.data(), 1, bytes.size(), stdout);
  std::fflush(stdout);
}

}  // namespace

Key key_of(std::string_view bytes) noexcept {
  while (!bytes.empty()) {
    const char first = bytes.front();
    // Arrow keys: ESC [ A up, B down, C right, D left; ESC O in application mode.
    if (first == kEscape && bytes.size() >= 3 && (bytes[1] == '[' || bytes[1] == 'O')) {
      if (bytes[2] == 'B' || bytes[2] == 'C') return Key::kNext;
      if (bytes[2] == 'A' || bytes[2] == 'D') return Key::kPrevious;
      bytes.remove_prefix(3);
      while (!bytes.empty() &&
             (bytes.front() == ';' || bytes.front() == '~' || (bytes.front() >= '0' && bytes.front() <= '9'))) {
        bytes.remove_prefix(1);
      }
      continue;
    }
    if (first == 'q' || first == 'Q' || first == kCtrlC || first == kEscape) return Key::kQuit;
    if (first == 'n' || first == 'N' || first == '\t') return Key::kNext;
    if (first == 'p' || first == 'P') return Key::kPrevious;
    if (first == 'r' || first == 'R') return Key::kReset;
    bytes.remove_prefix(1);
  }
  return Key::kNone;
}

std::string drawn(std::string_view page, std::size_t rows, std::size_t columns) {
  const auto visible = visible_text(page);
  std::string_view text = visible;
  std::string bytes(kHome);
  for (std::size_t row = 0; row < rows && !text.empty(); ++row) {
    const auto end = text.find('\n');
    bytes += text.substr(0, end == std::string_view::npos ? columns : std::min(end, columns));
    bytes += kClearLine;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    // A line end after the last row would scroll the page.
    if (row + 1 < rows && !text.empty()) bytes += "\r\n";
  }
  bytes += kClearBelow;
  return bytes;
}

bool TerminalPage::possible() noexcept {
  return isatty(STDIN_FILENO) != 0 && isatty(STDOUT_FILENO) != 0;
}

TerminalPage::TerminalPage() {
  termios settings{};
  if (tcgetattr(STDIN_FILENO, &settings) == 0) {
    before_ = settings;
    // Read key by key without echo, Ctrl-C included, so that the program can restore the terminal.
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG);
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &settings);
  }
  put(kOtherScreen);
}

TerminalPage::~TerminalPage() {
  put(kScreenBefore);
  if (before_) tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

void TerminalPage::show(std::string_view text) {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0;
  put(drawn(text, known ? size.ws_row : 50, known ? size.ws_col : 132));
}

Key TerminalPage::wait_for_key(std::chrono::milliseconds timeout) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, static_cast<int>(timeout.count())) <= 0) return Key::kNone;
  std::array<char, 64> bytes{};
  const auto count = read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count <= 0) return Key::kQuit;
  return key_of({bytes.data(), static_cast<std::size_t>(count)});
}

}  // namespace driveline::cli
