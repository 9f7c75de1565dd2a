#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace driveline::motion {

/// How long an axis may be without valid process data, and the master without a cycle. The drives' own watchdog is the
/// second line of defence.
///
/// Exchanges are counted, not cycles: a drive that is exchanged in every n-th cycle has not lost more by one frame than
/// a drive that is exchanged in every cycle.
struct LostLimit {
  std::uint32_t exchanges = 8;       ///< consecutive exchanges without valid process data; at least 1
  std::chrono::nanoseconds time{0};  ///< the limit as a time, which may allow fewer exchanges; 0: `exchanges` only

  /// Exchanges after which a drive that is exchanged in every `divider`-th cycle counts as lost; at least 1. `period`:
  /// cycle time. \rtsafe
  [[nodiscard]] constexpr std::uint32_t exchanges_of(std::uint32_t divider,
                                                     std::chrono::nanoseconds period) const noexcept {
    const auto interval = period * divider;
    if (time.count() <= 0 || interval.count() <= 0) return std::max(exchanges, 1U);
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(time / interval, 1, std::max(exchanges, 1U)));
  }
};

}  // namespace driveline::motion
