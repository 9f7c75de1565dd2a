#include "driveline/motion/cycle/cycle_record.hpp"

#include "driveline/rt/lateness.hpp"

namespace driveline::motion {

using std::chrono::nanoseconds;

bool CycleRecord::begin(const rt::CycleStart& start) noexcept {
  const auto switched = count_switched_.load(std::memory_order_acquire);
  const bool changed = switched != count_seen_;
  count_seen_ = switched;
  counting_ = counts(switched);
  const bool restarted = changed && counting_;
  if (restarted) {
    statistics_ = CycleStatistics{};
    if (settings_.trace != nullptr) settings_.trace->clear();
  }
  if (settings_.trace != nullptr) settings_.trace->begin(start, settings_.period);
  return restarted;
}

void CycleRecord::absence(const rt::CycleStart& start, MotionControl* motion, std::span<std::byte> outputs) noexcept {
  MasterAbsence absence;
  absence.duration = start.late(settings_.period);
  absence.since = start.wake - absence.duration;
  absence.cycle = static_cast<std::uint64_t>(start.cycle);
  if (motion != nullptr) {
    absence.effect = motion->resume(start.cycle, start.missed, outputs);
    absence.path_late = motion->path_late();
  }
  absences_.try_push(absence);
}

void CycleRecord::add(const rt::CycleStart& start, nanoseconds done, nanoseconds exchange) noexcept {
  if (settings_.trace != nullptr) settings_.trace->mark(CyclePhase::kTasksAfter, done);
  cost_ = done - start.wake;
  cycles_shared_.store(++cycles_, std::memory_order_release);
  if (!counting_) return;
  statistics_.cycles += 1;
  statistics_.missed_periods += static_cast<std::uint64_t>(start.missed);
  const auto late = start.late(settings_.period);
  rt::record_lateness(statistics_.wake_latency, late, start.missed, settings_.period);
  if (start.missed > 0 && late > statistics_.longest_absence) {
    statistics_.longest_absence = late;
    statistics_.longest_absence_at = start.wake - late;
  }
  statistics_.cost.record(cost_);
  statistics_.master_cost.record(cost_ - exchange);
}

void CycleRecord::fill(const rt::CycleStart& start, const MotionControl* motion,
                       snapshot::LineSample& line) const noexcept {
  line.cycle = static_cast<std::uint64_t>(start.cycle);
  line.time_ns = start.grid.count();
  line.wake_latency_ns = start.late(settings_.period).count();
  line.cost_ns = cost_.count();
  line.missed_periods = static_cast<std::uint32_t>(start.missed);
  line.axes = motion != nullptr ? static_cast<std::uint16_t>(motion->axes().size()) : std::uint16_t{0};
}

void CycleRecord::publish(const rt::CycleStart& start, const snapshot::LineSample& line, const MotionControl* motion,
                          bool bad_for_long) noexcept {
  if (settings_.recorder != nullptr) record(line, motion, bad_for_long);
  if (!sampled(start)) return;
  settings_.rings.lines->try_push(line);
  if (settings_.rings.axes == nullptr || motion == nullptr) return;
  motion::publish(*motion, line, *settings_.rings.axes);
}

void CycleRecord::record(const snapshot::LineSample& line, const MotionControl* motion, bool bad_for_long) noexcept {
  std::span<const Axis> axes;
  if (motion != nullptr) {
    axes = motion->axes();
    const bool failed = motion->failed();
    if (failed && !failure_recorded_) settings_.recorder->trigger();
    failure_recorded_ = failed;
  }
  if (bad_for_long) settings_.recorder->trigger();
  settings_.recorder->record(line, axes);
}

void CycleRecord::end(const rt::Clock& clock) noexcept {
  mark(CyclePhase::kPublish, clock);
  if (settings_.trace != nullptr && counting_) settings_.trace->end();
}

void CycleRecord::count(bool on) noexcept {
  auto switched = count_switched_.load(std::memory_order_relaxed);
  while (counts(switched) != on && !count_switched_.compare_exchange_weak(switched, switched + 1)) {
  }
}

}  // namespace driveline::motion
