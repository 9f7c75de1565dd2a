#pragma once

#include <chrono>
#include <optional>
#include <utility>

namespace driveline::slaves::msd {

/// Measures the SYNC0 period and checks whether the setpoint cycle fits it.
class Sync0Watch {
 public:
  /// Records a pulse at this time of the line's clock. \rtsafe
  void pulse(std::chrono::nanoseconds time) noexcept { period_ = time - std::exchange(last_, time); }

  /// Whether the cycle is a multiple of the SYNC0 period: setpoints arrive with every pulse or, on a line whose drives
  /// have process data less often, with every n-th pulse. Without pulses up to `now` every cycle fits. \rtsafe
  [[nodiscard]] bool fits(std::chrono::nanoseconds cycle, std::optional<std::chrono::nanoseconds> now) const noexcept {
    constexpr int kShare = 8;  // share of a period, for clock deviations
    const bool running = now && period_.count() > 0 && *now - last_ < 2 * period_;
    if (!running) return true;
    const auto pulses = (cycle + period_ / 2) / period_;
    return pulses > 0 && std::chrono::abs(cycle - pulses * period_) <= period_ / kShare;
  }

 private:
  std::chrono::nanoseconds last_{0};    ///< time of the last pulse
  std::chrono::nanoseconds period_{0};  ///< between the last two pulses; 0: no two pulses yet
};

}  // namespace driveline::slaves::msd
