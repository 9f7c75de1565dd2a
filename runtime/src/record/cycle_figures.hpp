#pragma once

#include <algorithm>
#include <mutex>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/rt/lateness.hpp"
#include "driveline/snapshot/sample_consumer.hpp"

namespace driveline::runtime {

/// Statistics of a running cycle, computed from its samples, because the cycle's own may be read only once it has
/// ended. Samples lost in full rings are missing.
class CycleFigures final : public snapshot::SampleConsumer {
 public:
  /// `period`: of the cycle from which the samples come.
  explicit CycleFigures(std::chrono::nanoseconds period) : period_(period) {}

  /// Returns the statistics since the telemetry started; any thread. Without master_cost, stale_frames and
  /// foreign_frames, which samples do not contain; lost frames and working counter errors count the cycles with at
  /// least one.
  [[nodiscard]] motion::CycleStatistics snapshot() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
  }

  // Called on the drain thread.
  void lines(std::span<const snapshot::LineSample> samples) override {
    using std::chrono::nanoseconds;
    const std::lock_guard lock(mutex_);
    for (const auto& sample : samples) {
      ++statistics_.cycles;
      statistics_.missed_periods += sample.missed_periods;
      const nanoseconds late{sample.wake_latency_ns};
      rt::record_lateness(statistics_.wake_latency, late, sample.missed_periods, period_);
      if (sample.missed_periods > 0) statistics_.longest_absence = std::max(statistics_.longest_absence, late);
      statistics_.cost.record(nanoseconds{sample.cost_ns});
      if (!sample.frame_received) {
        ++statistics_.lost_frames;
        continue;
      }
      statistics_.round_trip.record(nanoseconds{sample.round_trip_ns});
      if (sample.working_counter != sample.expected_working_counter) ++statistics_.wkc_errors;
    }
  }
  void axes(std::span<const snapshot::AxisSample>) override {}

 private:
  std::chrono::nanoseconds period_;
  mutable std::mutex mutex_;
  motion::CycleStatistics statistics_;  ///< guarded by mutex_
};

}  // namespace driveline::runtime
