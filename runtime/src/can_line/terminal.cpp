#include "can_line/terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace driveline::runtime {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> no_terminal(const fs::path& link, std::string_view what) {
  return fail(ErrorKind::kMachine, fmt::format("{}: {}", what, std::strerror(errno)), link.string());
}

/// Bytes pass as they are: no echo, no lines, no signals.
bool make_raw(int terminal) {
  termios settings{};
  if (::tcgetattr(terminal, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  return ::tcsetattr(terminal, TCSANOW, &settings) == 0;
}

/// Whether nothing is lost when the link is replaced: it leads to a terminal, or nowhere.
bool is_left_over(const fs::path& link) {
  std::error_code error;
  return fs::is_symlink(fs::symlink_status(link, error)) &&
         fs::read_symlink(link, error).string().starts_with("/dev/pts/");
}

}  // namespace

Terminal::Terminal(rt::FileDescriptor near_end, rt::FileDescriptor far_end, fs::path link)
    : near_end_(std::move(near_end)), far_end_(std::move(far_end)), link_(std::move(link)) {}

Terminal::Terminal(Terminal&& other) noexcept
    : near_end_(std::move(other.near_end_)),
      far_end_(std::move(other.far_end_)),
      link_(std::exchange(other.link_, {})) {}

Terminal::~Terminal() {
  if (!link_.empty()) ::unlink(link_.c_str());
}

Result<Terminal> Terminal::open(const fs::path& link) {
  rt::FileDescriptor near_end{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  std::array<char, 64> name{};
  if (!near_end.valid() || ::grantpt(near_end.get()) != 0 || ::unlockpt(near_end.get()) != 0 ||
      ::ptsname_r(near_end.get(), name.data(), name.size()) != 0) {
    return no_terminal(link, "no terminal can be made");
  }
  rt::FileDescriptor far_end{::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
  if (!far_end.valid() || !make_raw(far_end.get())) return no_terminal(link, "the terminal cannot be set up");
  if (is_left_over(link)) ::unlink(link.c_str());
  if (::symlink(name.data(), link.c_str()) != 0) return no_terminal(link, "no link to the terminal can be made");
  return Terminal(std::move(near_end), std::move(far_end), link);
}

}  // namespace driveline::runtime
