#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace driveline::snapshot {

/// EtherCAT state of the line: the lowest state of its slaves (ETG.1000.6, state machine), or kDown.
enum class LineState : std::uint8_t {
  kDown,  ///< the state of the slaves is unknown: not started, shut down or lost
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

/// Distribution of a time over an interval, of fixed size.
struct TimeDistribution {
  std::uint64_t count = 0;   ///< number of values
  std::int64_t p50_ns = 0;   ///< median
  std::int64_t p90_ns = 0;   ///< 90th percentile
  std::int64_t p99_ns = 0;   ///< 99th percentile
  std::int64_t p999_ns = 0;  ///< 99.9th percentile
  std::int64_t max_ns = 0;   ///< largest value
};

/// Counters and times of the cycle over an interval, of fixed size.
struct CycleInterval {
  std::int64_t duration_ns = 0;      ///< from the grid time before the first cycle to that of the last cycle
  std::uint64_t cycles = 0;          ///< number of cycles
  std::uint64_t missed_periods = 0;  ///< periods skipped because a cycle was late
  std::uint64_t wkc_errors = 0;      ///< cycles whose working counter was not the expected one
  std::uint64_t lost_frames = 0;     ///< cycles in which a frame did not return
  TimeDistribution wake_latency;     ///< wake-up after the grid time, missed periods included
  TimeDistribution cost;             ///< work of a cycle, wake-up to end of send
  TimeDistribution jitter;           ///< change of the wake-up latency from the previous cycle, absolute
  TimeDistribution round_trip;       ///< from sending to receiving the frames of a cycle
  TimeDistribution dc_difference;    ///< reference clock minus the master's estimate, absolute; locked cycles only
};

/// Statistics of the cycle, of fixed size, made once per second of the line's time.
struct CycleStatisticsSample {
  std::uint64_t number = 0;           ///< counts from 1; 0: no statistics yet
  std::int64_t time_ns = 0;           ///< grid time of the last cycle included
  std::uint64_t cycle = 0;            ///< number of the last cycle included
  std::int64_t wall_time_ns = 0;      ///< time at which the statistics were made, since 1970-01-01 UTC
  std::int64_t dc_difference_ns = 0;  ///< difference in the last cycle, signed
  std::uint64_t dc_locked = 0;        ///< not 0: the grid was locked to the reference clock in the last cycle
  CycleInterval last;                 ///< since the previous statistics
  CycleInterval total;                ///< since cyclic operation started
};

/// State and figures of the line for subscribers, as known to the owner of the line. The publisher adds the newest
/// cycle number, the clock's state and its own counters.
struct LineStatus {
  LineState state = LineState::kDown;        ///< AL state of the line as a whole
  std::chrono::nanoseconds cycle_period{0};  ///< period of the cycle
  std::uint64_t cycles = 0;                  ///< number of cycles
  std::uint64_t missed_periods = 0;          ///< periods skipped because a cycle was late
  std::uint64_t wkc_errors = 0;              ///< cycles whose working counter was not the expected one
  std::uint64_t lost_frames = 0;             ///< frames that did not return
  Percentiles wake_latency{};                ///< wake-up after the grid time, missed periods included
  Percentiles cycle_cost{};                  ///< work of a cycle, wake-up to end of send
  /// One sentence each, oldest first. The newest 16 are published, up to 255 bytes of each.
  std::vector<std::string> faults{};
  CycleStatisticsSample statistics{};  ///< the newest statistics
};

}  // namespace driveline::snapshot
