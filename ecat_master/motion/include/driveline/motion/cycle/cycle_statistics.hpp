#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/rt/histogram.hpp"

namespace driveline::motion {

/// Counters and times while counting was on; owned by the cycle, to be read after it has ended.
struct CycleStatistics {
  std::uint64_t cycles = 0;          ///< cycles that have run
  std::uint64_t missed_periods = 0;  ///< grid instants that were skipped because a cycle was late
  std::uint64_t wkc_errors =
      0;  ///< frames that came back with an unexpected working counter; on CAN, PDOs of a wrong length
  std::uint64_t lost_frames =
      0;  ///< cyclic frames that did not come back within their cycle; on CAN, PDOs that were due and did not come
  std::uint64_t late_frames = 0;   ///< lost_frames that came back in one of the next cycles
  std::uint64_t stale_frames = 0;  ///< frames that were no longer expected: late ones, duplicates, late acyclic answers
  std::uint64_t foreign_frames = 0;  ///< frames of other senders
  /// Cycles that received no further because too many frames came that they did not expect: answers of the line may
  /// have waited behind them.
  std::uint64_t flooded_cycles = 0;
  /// Time from the instant at which a cycle was due until it started, with every missed instant
  /// (rt::record_lateness()).
  rt::Histogram wake_latency;
  /// Longest time without a cycle: the lateness of a cycle that missed a period or more; 0: there was none.
  std::chrono::nanoseconds longest_absence{0};
  std::chrono::nanoseconds longest_absence_at{0};  ///< grid time at which that absence started
  rt::Histogram cost;                              ///< wake-up to the end of the cycle's work
  rt::Histogram master_cost;                       ///< `cost` without the time until all frames were back
  rt::Histogram round_trip;                        ///< from sending the first to receiving the last cyclic frame
};

}  // namespace driveline::motion
