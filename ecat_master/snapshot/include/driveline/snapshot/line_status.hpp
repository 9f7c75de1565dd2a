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
};

}  // namespace driveline::snapshot
