#include "driveline/canopen_master/can_cycle.hpp"

#include <algorithm>
#include <utility>

#include "process_exchange.hpp"
#include "work_clock.hpp"

namespace driveline::canopen {

using motion::CyclePhase;
using motion::TaskTiming;
using std::chrono::nanoseconds;

namespace {

motion::CycleRecord::Settings record_settings(const CanCycleSettings& settings, const MasterPlan& plan,
                                              motion::SampleRings rings) {
  motion::CycleRecord::Settings made;
  made.period = plan.period;
  made.sample_every = settings.sample_every;
  made.rings = rings;
  made.recorder = settings.recorder;
  made.trace = settings.trace;
  return made;
}

}  // namespace

/// The period of the last SYNC.
struct CanCycle::Period {
  rt::CycleStart start{};
  nanoseconds port_time{0};   ///< spent sending and receiving
  nanoseconds sync_late{0};   ///< SYNC left after the grid instant
  nanoseconds round_trip{0};  ///< from SYNC to the last TPDO; 0: not all came
  NodeTable::Verdict verdict{};
  bool open = false;  ///< its answers have not been judged yet

  /// Whether SYNC was sent and every TPDO that was due came.
  [[nodiscard]] bool complete(const ProcessExchange& exchange) const noexcept {
    return exchange.synced() && verdict.came == verdict.due;
  }
};

CanCycle::CanCycle(CanPort& port, rt::Clock& clock, const MasterPlan& plan, PdoImage image, AcyclicChannel& acyclic,
                   motion::MotionControl* motion, motion::SampleRings rings, Settings settings)
    : clock_(clock),
      period_(plan.period),
      bit_rate_(plan.bit_rate),
      settings_(std::move(settings)),
      motion_(motion),
      exchange_(std::make_unique<ProcessExchange>(port, clock, plan, std::move(image), acyclic)),
      record_(record_settings(settings_, plan, rings)),
      work_(std::make_unique<WorkClock>(clock)),
      present_(std::make_unique<Period>()) {}

CanCycle::~CanCycle() = default;

nanoseconds CanCycle::first_grid(nanoseconds earliest) const noexcept {
  return (earliest + period_ - nanoseconds{1}) / period_ * period_;
}

void CanCycle::prepare() noexcept {
  if (!present_->open) return;
  // After an absence, cycle() judges the period, because its outputs have come too late.
  if (clock_.now() - present_->start.grid >= 2 * period_) return;
  work_->go_on();
  // What is missing may come until SYNC is sent.
  if (receive()) {
    finish();
  } else {
    work_->pause();
  }
}

void CanCycle::cycle(const rt::CycleStart& start) noexcept {
  if (start.missed > 0 && record_.cycles() > 0) exchange_->outdate();
  exchange_->send_sync();
  nanoseconds spent{0};
  if (present_->open) {
    const auto from = clock_.now();
    work_->go_on();
    static_cast<void>(receive());
    finish();
    spent = clock_.now() - from;
  }
  work_->restart(spent);
  static_cast<void>(record_.begin(start));
  exchange_->begin_period(start.grid);
  if (start.missed > 0) record_.absence(start, motion_, exchange_->image().outputs());
  // Before the first answers there is nothing that a drive could follow.
  exchange_->send(record_.cycles() > 0);
  *present_ = Period{};
  present_->start = start;
  present_->sync_late = exchange_->synced().value_or(start.wake) - start.grid;
  present_->port_time = work_->now() - start.wake;
  present_->open = true;
  record_.mark(CyclePhase::kSend, *work_);
  work_->pause();
}

/// Returns whether all answers are there.
bool CanCycle::receive() noexcept {
  const auto from = work_->now();
  const bool complete = exchange_->receive();
  present_->port_time += work_->now() - from;
  return complete;
}

/// Ends the present period: its answers are judged, and the outputs of the next one are computed.
void CanCycle::finish() noexcept {
  auto& period = *present_;
  period.open = false;
  record_.mark(CyclePhase::kReceive, *work_);
  judge();
  record_.mark(CyclePhase::kJudge, *work_);
  const auto& image = std::as_const(*exchange_).image();
  const auto valid = exchange_->nodes().valid();
  if (motion_ != nullptr) {
    const auto took = std::clamp(period.sync_late + period.round_trip, nanoseconds{0}, period_);
    motion_->read_inputs(image.inputs(), valid, exchange_->nodes().supplied(), {}, took, period.sync_late);
  }
  record_.mark(CyclePhase::kInputs, *work_);
  if (settings_.tasks != nullptr) settings_.tasks->begin(period.start);
  run_tasks(TaskTiming::Order::kBeforeMotion);
  record_.mark(CyclePhase::kTasksBefore, *work_);
  if (motion_ != nullptr) motion_->update(period.start.cycle, exchange_->image().outputs());
  record_.mark(CyclePhase::kMotion, *work_);
  run_tasks(TaskTiming::Order::kAfterMotion);
  motion::apply_copies(settings_.copies, valid, image.inputs(), exchange_->image().outputs());
  record_.add(period.start, work_->now(), period.port_time);
  publish();
  record_.end(*work_);
}

void CanCycle::judge() noexcept {
  auto& period = *present_;
  period.verdict = exchange_->judge();
  const auto& tally = exchange_->tally();
  if (period.verdict.due > 0 && period.complete(*exchange_)) period.round_trip = tally.last - *exchange_->synced();
  const bool good = exchange_->synced() && period.verdict.all_valid;
  bad_cycles_.store(good ? 0 : bad_cycles_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (!record_.counting()) return;
  auto& counters = record_.counters();
  counters.lost_frames += period.verdict.due - period.verdict.came;
  counters.wkc_errors += tally.wrong_length;
  counters.stale_frames += tally.stale;
  counters.late_frames += tally.late;
  counters.foreign_frames += exchange_->foreign();
  if (exchange_->flooded()) ++counters.flooded_cycles;
  if (period.round_trip.count() > 0) counters.round_trip.record(period.round_trip);
}

void CanCycle::publish() noexcept {
  constexpr std::uint32_t kBadPeriods = 8;
  const auto& period = *present_;
  if (!record_.wants_sample(period.start)) return;
  snapshot::LineSample line;
  record_.fill(period.start, motion_, line);
  line.round_trip_ns = period.round_trip.count();
  line.working_counter = static_cast<std::uint16_t>(period.verdict.came);
  line.expected_working_counter = static_cast<std::uint16_t>(period.verdict.due);
  line.frame_received = period.complete(*exchange_);
  const double bits = std::chrono::duration<double>(period_).count() * bit_rate_;
  line.bus_load = static_cast<float>(static_cast<double>(exchange_->bits()) / bits);
  const auto& port = exchange_->port_statistics();
  line.bus_send_errors = port.send_errors.value_or(0);
  line.bus_receive_errors = port.receive_errors.value_or(0);
  record_.publish(period.start, line, motion_, bad_cycles() == kBadPeriods);
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

void CanCycle::set_operational(std::size_t node, bool operational) noexcept {
  exchange_->nodes().set_operational(node, operational);
}

NodeReport CanCycle::node_report(std::size_t node) const noexcept {
  return std::as_const(*exchange_).nodes().report(node);
}

CanCycleCounters CanCycle::counters() const noexcept {
  return exchange_->counters();
}

const PdoImage& CanCycle::image() const noexcept {
  return std::as_const(*exchange_).image();
}

}  // namespace driveline::canopen
