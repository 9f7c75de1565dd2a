#pragma once

#include <termios.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::cli {

/// A key as the pages know them.
enum class Key : std::uint8_t { kNone, kQuit, kNext, kPrevious, kReset };

/// The key in bytes from a terminal, which may hold several keys; the first known one counts. q, Escape and Ctrl-C
/// quit; n, Tab, right and down go on; p, left and up go back.
[[nodiscard]] Key key_of(std::string_view bytes) noexcept;

/// The terminal at stdin and stdout as a page that is drawn again and again: the other screen, no cursor, keys without
/// Enter. The destructor restores the terminal.
class TerminalPage {
 public:
  /// Whether stdin and stdout are a terminal.
  [[nodiscard]] static bool possible() noexcept;

  TerminalPage();
  TerminalPage(const TerminalPage&) = delete;
  TerminalPage& operator=(const TerminalPage&) = delete;
  ~TerminalPage();

  /// Draws `text` over what was there; what does not fit is cut off.
  void show(std::string_view text);
  /// Waits for a key; kNone after `timeout`. The end of the input quits.
  [[nodiscard]] Key wait_for_key(std::chrono::milliseconds timeout);

 private:
  std::optional<termios> before_;
};

/// `page` as the bytes that draw it: from the top left corner, every line and the rest of the screen cleared; at most
/// `rows` lines of `columns` characters. Control sequences in it are made visible.
[[nodiscard]] std::string drawn(std::string_view page, std::size_t rows, std::size_t columns);

}  // namespace driveline::cli
