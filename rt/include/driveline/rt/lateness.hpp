#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/rt/histogram.hpp"

namespace driveline::rt {

/// Records how late a wake-up was, with every instant of the grid that it missed: a thread that comes `late` after the
/// instant it slept for was late for each of the `missed` instants in between as well, for each by its own time. A
/// percentile of the histogram is then a share of the grid's instants, not of those that happened to be met.
///
/// Constant time for long absences: instants beyond the last kSingleInstants are counted with the whole time. \rtsafe
void record_lateness(Histogram& histogram, std::chrono::nanoseconds late, std::int64_t missed,
                     std::chrono::nanoseconds period) noexcept;

/// See record_lateness().
inline constexpr std::int64_t kSingleInstants = 8192;

}  // namespace driveline::rt
