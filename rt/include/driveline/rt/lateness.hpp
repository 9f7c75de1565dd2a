#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/rt/histogram.hpp"

namespace driveline::rt {

/// Records how late a wake-up was, for every grid instant that it missed: a thread that wakes `late` after the instant
/// it slept for was also late for each of the `missed` instants in between, each by a period less. A percentile of the
/// histogram is therefore a share of all grid instants, not only of those that were met.
///
/// Constant time for long absences: instants before the last kSingleInstants are counted with the whole time. \rtsafe
void record_lateness(Histogram& histogram, std::chrono::nanoseconds late, std::int64_t missed,
                     std::chrono::nanoseconds period) noexcept;

/// Number of missed instants that record_lateness() records one by one.
inline constexpr std::int64_t kSingleInstants = 8192;

}  // namespace driveline::rt
