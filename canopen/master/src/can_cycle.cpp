#include "driveline/canopen_master/can_cycle.hpp"

#include <algorithm>
#include <utility>

#include "cycle_figures.hpp"
#include "process_exchange.hpp"

namespace driveline::canopen {

using motion::CyclePhase;
using motion::TaskTiming;
using std::chrono::nanoseconds;

CanCycle::CanCycle(CanPort& port, rt::Clock& clock, const MasterPlan& plan, PdoImage image, AcyclicChannel& acyclic,
                   motion::MotionControl* motion, motion::SampleRings rings, Settings settings)
    : clock_(clock),
      period_(plan.period),
      bit_rate_(plan.bit_rate),
      settings_(std::move(settings)),
      motion_(motion),
      exchange_(std::make_unique<ProcessExchange>(port, clock, plan, std::move(image), acyclic)),
      figures_(std::make_unique<CycleFigures>(settings_, period_, rings, motion)),
      present_(std::make_unique<PeriodRecord>()) {}

CanCycle::~CanCycle() = default;

nanoseconds CanCycle::first_grid(nanoseconds earliest) const noexcept {
  return (earliest + period_ - nanoseconds{1}) / period_ * period_;
}

void CanCycle::lap(PeriodRecord& record, CyclePhase phase) noexcept {
  const auto now = clock_.now();
  record.of(phase) += now - lap_at_;
  lap_at_ = now;
}

/// Without a trace nobody asks for the time between two of these phases; it counts for the one that is measured next.
void CanCycle::traced_lap(CyclePhase phase) noexcept {
  if (settings_.trace != nullptr) lap(*present_, phase);
}

void CanCycle::prepare() noexcept {
  if (!open_) return;
  lap_at_ = clock_.now();
  const bool complete = exchange_->receive();
  lap(*present_, CyclePhase::kReceive);
  // What is missing may come until SYNC is sent.
  if (complete) compute();
}

void CanCycle::cycle(const rt::CycleStart& start) noexcept {
  figures_->take_counting(*present_);
  PeriodRecord next;
  next.start = start;
  next.counted = figures_->counting();
  lap_at_ = start.wake;
  exchange_->send_sync();
  lap(next, CyclePhase::kSend);
  if (open_) {
    static_cast<void>(exchange_->receive());
    lap(*present_, CyclePhase::kReceive);
    compute();
  }
  const bool running = cycles_shared_.load(std::memory_order_relaxed) > 0;
  PeriodRecord done = std::exchange(*present_, next);
  done.bus_load = load_of(done, start);
  exchange_->begin_period(start.grid);
  present_->synced = exchange_->synced().has_value();
  present_->sync_late = exchange_->synced().value_or(start.wake) - start.grid;
  if (start.missed > 0) note_absence(start);
  // Before the first answers there is nothing that a drive could follow.
  exchange_->send(running);
  open_ = true;
  lap(*present_, CyclePhase::kSend);
  cycles_shared_.fetch_add(1, std::memory_order_release);
  if (!running) return;
  figures_->finish(done, bad_cycles());
  lap(done, CyclePhase::kPublish);
  figures_->trace(done);
}

/// Ends the present period: its answers are judged, and the outputs of the next one are computed.
void CanCycle::compute() noexcept {
  auto& record = *present_;
  open_ = false;
  judge(record);
  traced_lap(CyclePhase::kJudge);
  const auto& image = std::as_const(*exchange_).image();
  const auto valid = exchange_->nodes().valid();
  if (motion_ != nullptr) {
    const auto took = std::clamp(record.sync_late + record.round_trip, nanoseconds{0}, period_);
    motion_->read_inputs(image.inputs(), valid, valid, {}, took, record.sync_late);
  }
  traced_lap(CyclePhase::kInputs);
  if (settings_.tasks != nullptr) settings_.tasks->begin(record.start);
  run_tasks(TaskTiming::Order::kBeforeMotion);
  traced_lap(CyclePhase::kTasksBefore);
  if (motion_ != nullptr) motion_->update(record.start.cycle, exchange_->image().outputs());
  traced_lap(CyclePhase::kMotion);
  run_tasks(TaskTiming::Order::kAfterMotion);
  motion::apply_copies(settings_.copies, valid, image.inputs(), exchange_->image().outputs());
  lap(record, CyclePhase::kTasksAfter);
}

void CanCycle::judge(PeriodRecord& record) noexcept {
  record.verdict = exchange_->judge();
  const auto& tally = exchange_->tally();
  record.wrong_length = tally.wrong_length;
  record.stale = tally.stale;
  record.late = tally.late;
  record.foreign = exchange_->foreign();
  record.flooded = exchange_->flooded();
  record.bits = exchange_->bits();
  const auto& port = exchange_->port_statistics();
  record.send_errors = port.send_errors.value_or(0);
  record.receive_errors = port.receive_errors.value_or(0);
  const bool complete = record.synced && record.verdict.came == record.verdict.due;
  if (complete && record.verdict.due > 0) record.round_trip = tally.last - *exchange_->synced();
  const bool good = record.synced && record.verdict.all_valid;
  bad_cycles_.store(good ? 0 : bad_cycles_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

void CanCycle::run_tasks(TaskTiming::Order order) noexcept {
  if (settings_.tasks == nullptr) return;
  const auto& image = std::as_const(*exchange_).image();
  motion::TaskCycle now;
  now.cycle = present_->start.cycle;
  now.grid = present_->start.grid;
  if (motion_ != nullptr) {
    now.axes = motion_->axes();
    now.setpoints = motion_->setpoints();
  }
  now.inputs = image.inputs();
  now.valid = exchange_->nodes().valid();
  now.outputs = exchange_->image().outputs();
  settings_.tasks->run(order, now, period_, clock_);
}

/// Runs before any RPDO is sent: outputs computed for a skipped period are no longer valid for the drives.
void CanCycle::note_absence(const rt::CycleStart& start) noexcept {
  motion::MasterAbsence absence;
  absence.duration = start.late(period_);
  absence.since = start.wake - absence.duration;
  absence.cycle = static_cast<std::uint64_t>(start.cycle);
  if (motion_ != nullptr) {
    absence.effect = motion_->resume(start.cycle, start.missed, exchange_->image().outputs());
    absence.path_late = motion_->path_late();
  }
  absences_.try_push(absence);
}

/// Share of the time from the SYNC of the period until the next one.
float CanCycle::load_of(const PeriodRecord& record, const rt::CycleStart& next) const noexcept {
  using Seconds = std::chrono::duration<double>;
  const double seconds = Seconds(next.grid - record.start.grid).count();
  return seconds > 0.0 ? static_cast<float>(static_cast<double>(record.bits) / (seconds * bit_rate_)) : 0.0F;
}

void CanCycle::set_operational(std::size_t node, bool operational) noexcept {
  exchange_->nodes().set_operational(node, operational);
}

NodeReport CanCycle::node_report(std::size_t node) const noexcept {
  return std::as_const(*exchange_).nodes().report(node);
}

void CanCycle::count(bool on) noexcept {
  figures_->count(on);
}

CanCycleCounters CanCycle::counters() const noexcept {
  return exchange_->counters();
}

const motion::CycleStatistics& CanCycle::statistics() const noexcept {
  return figures_->statistics();
}

const PdoImage& CanCycle::image() const noexcept {
  return std::as_const(*exchange_).image();
}

}  // namespace driveline::canopen
