#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::runtime {

/// Counts what the cycle does, out of its samples.
class CycleTally {
 public:
  /// `period`: of the cycle.
  explicit CycleTally(std::chrono::nanoseconds period) : period_(period) {}

  /// The next cycle; `latency_before`: wake-up latency of the one before, none for the first.
  void add(const snapshot::LineSample& sample, std::optional<std::int64_t> latency_before) noexcept;
  /// What was counted since the last reset().
  [[nodiscard]] snapshot::CycleInterval interval() const noexcept;
  /// Forgets everything.
  void reset() noexcept;

 private:
  std::chrono::nanoseconds period_;
  snapshot::CycleInterval counts_;
  rt::Histogram wake_latency_;
  rt::Histogram cost_;
  rt::Histogram jitter_;
  rt::Histogram round_trip_;
  rt::Histogram dc_difference_;
};

/// Makes CycleStatistics once in a second of the line's time.
class StatisticsClock {
 public:
  /// Between two statistics, on the clock of the cycle.
  static constexpr std::chrono::nanoseconds kInterval = std::chrono::seconds{1};

  /// `period`: of the cycle.
  explicit StatisticsClock(std::chrono::nanoseconds period) : period_(period), last_(period), total_(period) {}

  /// The next cycle. True: there are new statistics.
  [[nodiscard]] bool add(const snapshot::LineSample& sample);
  /// Statistics of what has come since the last ones. False: nothing has.
  [[nodiscard]] bool close();
  /// The newest ones.
  [[nodiscard]] const snapshot::CycleStatistics& statistics() const noexcept { return statistics_; }

 private:
  std::chrono::nanoseconds period_;
  CycleTally last_;
  CycleTally total_;
  std::optional<snapshot::LineSample> newest_;
  std::int64_t begun_ns_ = 0;  ///< grid time from which `last_` counts
  snapshot::CycleStatistics statistics_;
};

}  // namespace driveline::runtime
