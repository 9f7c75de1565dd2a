#pragma once

#include <termios.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::cli {

/// The keys that the pages react to.
enum class Key : std::uint8_t { kNone, kQuit, kNext, kPrevious, kReset };

/// Decodes bytes from a terminal, which may hold several keys: returns the first known one. q, Escape and Ctrl-C quit;
/// n, Tab, right and down show the next page, p, left and up the previous one; r is kReset.
[[nodiscard]] Key key_of(std::string_view bytes) noexcept;

/// The terminal at stdin and stdout as a page that is redrawn repeatedly: alternate screen, no cursor, keys without
/// Enter. The destructor restores the terminal.
class TerminalPage {
 public:
  /// Whether stdin and stdout are a terminal.
  [[nodiscard]] static bool possible() noexcept;

  TerminalPage();
  TerminalPage(const TerminalPage&) = delete;
  TerminalPage& operator=(const TerminalPage&) = delete;
  ~TerminalPage();

  /// Draws `text` over the previous page; text that does not fit is cut off.
  void show(std::string_view text);
  /// Waits for a key; kNone after `timeout`. The end of the input is kQuit.
  [[nodiscard]] Key wait_for_key(std::chrono::milliseconds timeout);

 private:
  std::optional<termios> before_;
};

/// The bytes that draw `page` from the top left corner, clearing every line and the rest of the screen; at most `rows`
/// lines of `columns` characters. Control sequences in `page` are made visible.
[[nodiscard]] std::string drawn(std::string_view page, std::size_t rows, std::size_t columns);

}  // namespace driveline::cli
