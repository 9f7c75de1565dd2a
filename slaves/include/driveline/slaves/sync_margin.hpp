#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace driveline::slaves {

/// How long before the SYNC pulse that uses them the outputs of a slave were complete, in true time, counted since OP
/// was entered: as a drive measures it (ETG.1020, 1C32h:11 and :12, SM SYNC distance). \rtsafe
struct SyncMargin {
  std::chrono::nanoseconds shortest = std::chrono::nanoseconds::max();  ///< its maximum while no pulse found outputs
  std::chrono::nanoseconds longest{0};                                  ///< of the pulses that found new outputs
  std::chrono::nanoseconds sum{0};                                      ///< of all these, for mean()
  std::uint64_t pulses = 0;                                             ///< that found new outputs
  std::uint64_t missed = 0;                                             ///< that found none (1C32h:0B, SM event missed)

  /// A pulse found new outputs that had been complete for `margin`.
  constexpr void found(std::chrono::nanoseconds margin) noexcept {
    shortest = std::min(shortest, margin);
    longest = std::max(longest, margin);
    sum += margin;
    ++pulses;
  }
  /// 0 without any pulse that found new outputs.
  [[nodiscard]] constexpr std::chrono::nanoseconds mean() const noexcept {
    return pulses == 0 ? std::chrono::nanoseconds{0} : sum / static_cast<std::int64_t>(pulses);
  }
};

}  // namespace driveline::slaves
