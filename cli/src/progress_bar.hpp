#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace driveline::cli {

/// "[#####.....]  50 %  10.0 of 20.0 KiB"; with `total` 0 (unknown): "10.0 KiB".
[[nodiscard]] std::string progress_text(std::size_t done, std::size_t total);

/// Shows the progress of a long operation on stderr, if that is a terminal. The destructor clears the bar.
class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();
  /// Redraws the bar, at most every 100 ms.
  void show(std::size_t done, std::size_t total);

 private:
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace driveline::cli
