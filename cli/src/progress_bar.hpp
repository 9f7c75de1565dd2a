#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace driveline::cli {

/// "[#####.....]  50 %  10.0 of 20.0 KiB"; `total` 0, not known: "10.0 KiB".
[[nodiscard]] std::string progress_text(std::size_t done, std::size_t total);

/// How far something long is, on stderr, when that is a terminal; nothing of it stays behind.
class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();
  /// Draws it anew, not more often than people can read.
  void show(std::size_t done, std::size_t total);

 private:
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace driveline::cli
