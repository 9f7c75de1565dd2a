#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "driveline/canopen_master/can_cycle_settings.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/cycle/cycle_statistics.hpp"
#include "driveline/motion/cycle/sample_rings.hpp"
#include "period_record.hpp"

namespace driveline::canopen {

/// What the cycle tells of its periods: statistics, trace, samples and the flight recorder.
class CycleFigures {
 public:
  /// `motion` may be null. What settings and rings point to must outlive this.
  CycleFigures(const CanCycleSettings& settings, std::chrono::nanoseconds period, motion::SampleRings rings,
               const motion::MotionControl* motion);

  /// Switches the statistics on or off from the next cycle on. Any thread. \rtsafe
  void count(bool on) noexcept;
  /// Takes over count(); to be called at the start of a cycle. `present`: the period that has not been finished.
  /// \rtsafe
  void take_counting(PeriodRecord& present) noexcept;
  /// Whether the statistics are on. \rtsafe
  [[nodiscard]] bool counting() const noexcept { return counting_; }
  /// Counts a period and publishes its samples. `bad`: consecutive periods that were not valid for all nodes. \rtsafe
  void finish(const PeriodRecord& record, std::uint32_t bad) noexcept;
  /// Adds the period to the trace, if there is one. \rtsafe
  void trace(const PeriodRecord& record) noexcept;
  /// Only while no cycle runs.
  [[nodiscard]] const motion::CycleStatistics& statistics() const noexcept { return statistics_; }

 private:
  void tally(const PeriodRecord& record) noexcept;
  [[nodiscard]] snapshot::LineSample line_sample(const PeriodRecord& record) const noexcept;
  void record(const snapshot::LineSample& line, std::uint32_t bad) noexcept;

  std::uint32_t sample_every_;
  motion::FlightRecorder* recorder_;
  motion::CycleTrace* trace_;
  std::chrono::nanoseconds period_;
  motion::SampleRings rings_;
  const motion::MotionControl* motion_;
  motion::CycleStatistics statistics_;
  bool counting_ = true;
  bool failure_recorded_ = false;
  std::uint64_t count_seen_ = 1;                  ///< value of count_switched_ in the last cycle
  std::atomic<std::uint64_t> count_switched_{1};  ///< number of times that count() changed; odd: on
};

}  // namespace driveline::canopen
