#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::runtime {

/// Counts events of the cycle, from its samples.
class CycleTally {
 public:
  /// `period`: cycle time.
  explicit CycleTally(std::chrono::nanoseconds period) : period_(period) {}

  /// Adds the next cycle; `latency_before`: wake-up latency of the preceding one, none for the first.
  void add(const snapshot::LineSample& sample, std::optional<std::int64_t> latency_before) noexcept;
  /// Returns the counts since the last reset().
  [[nodiscard]] snapshot::CycleInterval interval() const noexcept;
  /// Clears all counts.
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

/// Makes CycleStatisticsSample once per second of the line's time.
class StatisticsClock {
 public:
  /// Interval between two statistics, on the clock of the cycle.
  static constexpr std::chrono::nanoseconds kInterval = std::chrono::seconds{1};

  /// `period`: cycle time.
  explicit StatisticsClock(std::chrono::nanoseconds period) : period_(period), last_(period), total_(period) {}

  /// Adds the next cycle. True: there are new statistics.
  [[nodiscard]] bool add(const snapshot::LineSample& sample);
  /// Makes statistics of the samples since the last ones. False: there were no samples.
  [[nodiscard]] bool close();
  /// Returns the newest statistics.
  [[nodiscard]] const snapshot::CycleStatisticsSample& statistics() const noexcept { return statistics_; }

 private:
  std::chrono::nanoseconds period_;
  CycleTally last_;
  CycleTally total_;
  std::optional<snapshot::LineSample> newest_;
  std::int64_t begun_ns_ = 0;  ///< grid time at which `last_` starts
  snapshot::CycleStatisticsSample statistics_;
};

}  // namespace driveline::runtime
