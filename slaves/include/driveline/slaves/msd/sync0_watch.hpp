#pragma once

#include <chrono>
#include <optional>
#include <utility>

namespace driveline::slaves::msd {

/// When SYNC0 comes, and whether the setpoints can come with it.
class Sync0Watch {
 public:
  /// A pulse at this time of the line's clock. \rtsafe
  void pulse(std::chrono::nanoseconds time) noexcept { period_ = time - std::exchange(last_, time); }

  /// Setpoints come every SYNC0 or, of a line whose drives have process data less often, every so many of them. Without
  /// pulses up to `now` any cycle will do. \rtsafe
  [[nodiscard]] bool fits(std::chrono::nanoseconds cycle, std::optional<std::chrono::nanoseconds> now) const noexcept {
    constexpr int kShare = 8;  // of a period, for clocks that differ
    const bool running = now && period_.count() > 0 && *now - last_ < 2 * period_;
    if (!running) return true;
    const auto pulses = (cycle + period_ / 2) / period_;
    return pulses > 0 && std::chrono::abs(cycle - pulses * period_) <= period_ / kShare;
  }

 private:
  std::chrono::nanoseconds last_{0};    ///< the last pulse
  std::chrono::nanoseconds period_{0};  ///< between the last two; 0: there were none
};

}  // namespace driveline::slaves::msd
