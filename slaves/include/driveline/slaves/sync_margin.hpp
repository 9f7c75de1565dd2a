#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace driveline::slaves {

/// Time from the completion of a slave's outputs to the SYNC pulse that uses them, in true time, counted since OP was
/// entered; a drive measures it in the same way (ETG.1020, 1C32h:11 and :12, SM SYNC distance). \rtsafe
struct SyncMargin {
  std::chrono::nanoseconds shortest = std::chrono::nanoseconds::max();  ///< max() until a pulse finds new outputs
  std::chrono::nanoseconds longest{0};                                  ///< over the pulses that found new outputs
  std::chrono::nanoseconds sum{0};                                      ///< over the same pulses, for mean()
  std::uint64_t pulses = 0;                                             ///< pulses that found new outputs
  std::uint64_t missed = 0;                                             ///< pulses without (1C32h:0B, SM event missed)
  std::uint64_t exceeded = 0;   ///< pulses while the application was still busy (1C32h:0C, cycle exceeded)
  std::uint64_t too_short = 0;  ///< pulses whose margin was less than the demand (1C32h:0D, shift too short)

  /// Counts a pulse that found new outputs, complete for `margin`.
  constexpr void found(std::chrono::nanoseconds margin) noexcept {
    shortest = std::min(shortest, margin);
    longest = std::max(longest, margin);
    sum += margin;
    ++pulses;
  }
  /// Returns the mean margin; 0 before the first pulse that found new outputs.
  [[nodiscard]] constexpr std::chrono::nanoseconds mean() const noexcept {
    return pulses == 0 ? std::chrono::nanoseconds{0} : sum / static_cast<std::int64_t>(pulses);
  }
};

}  // namespace driveline::slaves
