#include "progress_bar.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace driveline::cli {
namespace {

constexpr std::size_t kWidth = 40;
constexpr double kKibi = 1024.0;
constexpr auto kBetweenDrawings = std::chrono::milliseconds{100};

void write_terminal(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::string progress_text(std::size_t done, std::size_t total) {
  const double kibi = static_cast<double>(done) / kKibi;
  if (total == 0) return fmt::format("{:.1f} KiB", kibi);
  const auto part = static_cast<double>(std::min(done, total)) / static_cast<double>(total);
  const auto full = static_cast<std::size_t>(part * kWidth);
  return fmt::format("[{}{}] {:3} %  {:.1f} of {:.1f} KiB", std::string(full, '#'), std::string(kWidth - full, '.'),
                     static_cast<int>(part * 100), kibi, static_cast<double>(total) / kKibi);
}

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (drawn_) write_terminal("\r\033[K");
}

void ProgressBar::show(std::size_t done, std::size_t total) {
  const auto now = std::chrono::steady_clock::now();
  if (!terminal_ || now < next_) return;
  next_ = now + kBetweenDrawings;
  drawn_ = true;
  write_terminal("\r" + progress_text(done, total) + "\033[K");
}

}  // namespace driveline::cli
