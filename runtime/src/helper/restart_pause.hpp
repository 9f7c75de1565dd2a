#pragma once

#include <algorithm>
#include <chrono>

namespace driveline::runtime {

/// Pause before a helper process that has died is restarted: doubled each time, up to a limit.
class RestartPause {
 public:
  /// `first` and `longest`: positive.
  constexpr RestartPause(std::chrono::milliseconds first, std::chrono::milliseconds longest) noexcept
      : first_(first), longest_(longest) {}

  /// Returns the pause after another death of the process.
  [[nodiscard]] constexpr std::chrono::milliseconds next() noexcept {
    pause_ = pause_.count() == 0 ? first_ : std::min(2 * pause_, longest_);
    return pause_;
  }
  /// Resets the pause after the process has worked.
  constexpr void reset() noexcept { pause_ = std::chrono::milliseconds{0}; }

 private:
  std::chrono::milliseconds first_;
  std::chrono::milliseconds longest_;
  std::chrono::milliseconds pause_{0};
};

}  // namespace driveline::runtime
