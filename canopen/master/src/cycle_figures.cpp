#include "cycle_figures.hpp"

#include <numeric>

#include "driveline/rt/lateness.hpp"

namespace driveline::canopen {

using motion::CyclePhase;
using std::chrono::nanoseconds;

namespace {

/// Whether the statistics are on after so many changes; they are on after the first.
constexpr bool counts(std::uint64_t switched) noexcept {
  return (switched & 1U) != 0;
}

nanoseconds spent_in(const PeriodRecord& record, CyclePhase phase) noexcept {
  return record.spent[static_cast<std::size_t>(phase)];
}

/// Work of the master: all but the publishing, which comes behind it.
nanoseconds cost_of(const PeriodRecord& record) noexcept {
  return std::accumulate(record.spent.begin(), record.spent.end(), nanoseconds{0}) -
         spent_in(record, CyclePhase::kPublish);
}

}  // namespace

CycleFigures::CycleFigures(const CanCycleSettings& settings, nanoseconds period, motion::SampleRings rings,
                           const motion::MotionControl* motion)
    : sample_every_(settings.sample_every),
      recorder_(settings.recorder),
      trace_(settings.trace),
      period_(period),
      rings_(rings),
      motion_(motion) {}

void CycleFigures::count(bool on) noexcept {
  auto switched = count_switched_.load(std::memory_order_relaxed);
  while (counts(switched) != on && !count_switched_.compare_exchange_weak(switched, switched + 1)) {
  }
}

void CycleFigures::take_counting(PeriodRecord& present) noexcept {
  const auto switched = count_switched_.load(std::memory_order_acquire);
  if (switched == count_seen_) return;
  count_seen_ = switched;
  counting_ = counts(switched);
  if (!counting_) return;
  present.counted = false;
  statistics_ = motion::CycleStatistics{};
  if (trace_ != nullptr) trace_->clear();
}

void CycleFigures::tally(const PeriodRecord& record) noexcept {
  statistics_.cycles += 1;
  statistics_.missed_periods += static_cast<std::uint64_t>(record.start.missed);
  const auto late = record.start.late(period_);
  rt::record_lateness(statistics_.wake_latency, late, record.start.missed, period_);
  if (record.start.missed > 0 && late > statistics_.longest_absence) {
    statistics_.longest_absence = late;
    statistics_.longest_absence_at = record.start.wake - late;
  }
  statistics_.lost_frames += record.verdict.due - record.verdict.came;
  statistics_.wkc_errors += record.wrong_length;
  statistics_.stale_frames += record.stale;
  statistics_.late_frames += record.late;
  statistics_.foreign_frames += record.foreign;
  if (record.flooded) ++statistics_.flooded_cycles;
  const auto cost = cost_of(record);
  statistics_.cost.record(cost);
  statistics_.master_cost.record(cost - spent_in(record, CyclePhase::kSend) - spent_in(record, CyclePhase::kReceive));
  if (record.round_trip.count() > 0) statistics_.round_trip.record(record.round_trip);
}

snapshot::LineSample CycleFigures::line_sample(const PeriodRecord& record) const noexcept {
  snapshot::LineSample line;
  line.cycle = static_cast<std::uint64_t>(record.start.cycle);
  line.time_ns = record.start.grid.count();
  line.wake_latency_ns = record.start.late(period_).count();
  line.cost_ns = cost_of(record).count();
  line.round_trip_ns = record.round_trip.count();
  line.missed_periods = static_cast<std::uint32_t>(record.start.missed);
  line.working_counter = static_cast<std::uint16_t>(record.verdict.came);
  line.expected_working_counter = static_cast<std::uint16_t>(record.verdict.due);
  line.frame_received = record.synced && record.verdict.came == record.verdict.due;
  line.axes = motion_ != nullptr ? static_cast<std::uint16_t>(motion_->axes().size()) : std::uint16_t{0};
  line.bus_load = record.bus_load;
  line.bus_send_errors = record.send_errors;
  line.bus_receive_errors = record.receive_errors;
  return line;
}

void CycleFigures::finish(const PeriodRecord& record, std::uint32_t bad) noexcept {
  if (record.counted) tally(record);
  const bool sampled = rings_.lines != nullptr && record.start.cycle % sample_every_ == 0;
  if (!sampled && recorder_ == nullptr) return;
  const auto line = line_sample(record);
  if (recorder_ != nullptr) this->record(line, bad);
  if (!sampled) return;
  rings_.lines->try_push(line);
  if (rings_.axes != nullptr && motion_ != nullptr) motion::publish(*motion_, line, *rings_.axes);
}

/// Triggers the recorder when the motion has failed, or when process data have been bad for long.
void CycleFigures::record(const snapshot::LineSample& line, std::uint32_t bad) noexcept {
  constexpr std::uint32_t kBadPeriods = 8;
  std::span<const motion::Axis> axes;
  if (motion_ != nullptr) {
    axes = motion_->axes();
    const bool failed = motion_->failed();
    if (failed && !failure_recorded_) recorder_->trigger();
    failure_recorded_ = failed;
  }
  if (bad == kBadPeriods) recorder_->trigger();
  recorder_->record(line, axes);
}

void CycleFigures::trace(const PeriodRecord& record) noexcept {
  if (trace_ == nullptr || !record.counted) return;
  trace_->begin(record.start, period_);
  auto end = record.start.wake;
  for (std::size_t phase = 0; phase < motion::kCyclePhases; ++phase) {
    end += record.spent[phase];
    trace_->mark(static_cast<CyclePhase>(phase), end);
  }
  trace_->end();
}

}  // namespace driveline::canopen
