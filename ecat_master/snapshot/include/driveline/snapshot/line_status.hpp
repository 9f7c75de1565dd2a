#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace driveline::snapshot {

/// EtherCAT state of the line: the lowest state of its slaves (ETG.1000.6, state machine), or the absence of one.
enum class LineState : std::uint8_t {
  kDown,  ///< nothing is known of the slaves: not started, shut down or lost
  kInit,
  kPreOp,
  kSafeOp,
  kOp,
};

/// Distribution of a time since cyclic operation started.
struct Percentiles {
  std::chrono::nanoseconds p50{0};  ///< median
  std::chrono::nanoseconds p99{0};  ///< 99th percentile
  std::chrono::nanoseconds max{0};  ///< largest value
};

/// Distribution of a time over a while, of fixed size.
struct TimeDistribution {
  std::uint64_t count = 0;   ///< values
  std::int64_t p50_ns = 0;   ///< median
  std::int64_t p90_ns = 0;   ///< 90th percentile
  std::int64_t p99_ns = 0;   ///< 99th percentile
  std::int64_t p999_ns = 0;  ///< 99.9th percentile
  std::int64_t max_ns = 0;   ///< largest value
};

/// What the cycle has done in a while, of fixed size.
struct CycleInterval {
  std::int64_t duration_ns = 0;      ///< from the grid time before its first cycle to that of its last one
  std::uint64_t cycles = 0;          ///< cycles that have run
  std::uint64_t missed_periods = 0;  ///< periods skipped because a cycle was late
  std::uint64_t wkc_errors = 0;      ///< cycles whose working counter was not the expected one
  std::uint64_t lost_frames = 0;     ///< cycles in which a frame did not come back
  TimeDistribution wake_latency;     ///< wake-up after the grid time, missed periods included
  TimeDistribution cost;             ///< work of a cycle, wake-up to end of send
  TimeDistribution jitter;           ///< wake-up latency against that of the cycle before, without sign
  TimeDistribution round_trip;       ///< send to receive of the frames of a cycle
  TimeDistribution dc_difference;    ///< reference clock against the master's estimate, without sign; locked cycles
};

/// Statistics of the cycle, of fixed size, once in a second of the line's time.
struct CycleStatistics {
  std::uint64_t number = 0;           ///< from 1; 0: there are none yet
  std::int64_t time_ns = 0;           ///< grid time of the last cycle that counts
  std::uint64_t cycle = 0;            ///< its number
  std::int64_t wall_time_ns = 0;      ///< when they were made, since 1970-01-01 UTC
  std::int64_t dc_difference_ns = 0;  ///< of the last cycle, with its sign
  std::uint64_t dc_locked = 0;        ///< not 0: the grid was locked to the reference clock in the last cycle
  CycleInterval last;                 ///< since the statistics before these
  CycleInterval total;                ///< since cyclic operation started
};

/// State and figures of the line for subscribers, as far as its owner knows them. The publisher adds the newest cycle
/// number, the clock's state and its own counters.
struct LineStatus {
  LineState state = LineState::kDown;        ///< AL state of the line as a whole
  std::chrono::nanoseconds cycle_period{0};  ///< grid of the cycle
  std::uint64_t cycles = 0;                  ///< cycles run
  std::uint64_t missed_periods = 0;          ///< periods skipped because a cycle was late
  std::uint64_t wkc_errors = 0;              ///< cycles whose working counter was not the expected one
  std::uint64_t lost_frames = 0;             ///< frames that did not come back
  Percentiles wake_latency{};                ///< wake-up after the grid time, missed periods included
  Percentiles cycle_cost{};                  ///< work of a cycle, wake-up to end of send
  /// One sentence each, oldest first. The newest 16 are published, up to 255 bytes of each.
  std::vector<std::string> faults{};
  CycleStatistics statistics{};  ///< the newest ones
};

}  // namespace driveline::snapshot
