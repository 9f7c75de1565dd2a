#include "driveline/ecat_master/cyclic/cyclic_core.hpp"

#include <algorithm>

#include "driveline/ecat_master/cyclic/acyclic_budget.hpp"
#include "driveline/rt/lateness.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {

using std::chrono::nanoseconds;

namespace {

bool in_op(std::uint8_t al_status) noexcept {
  return wire::AlStatus::from_raw(al_status).state == wire::AlState::kOp;
}

/// Interval at which a wait for frames yields the CPU to threads of the same priority.
constexpr nanoseconds kYieldInterval = std::chrono::microseconds{25};

// Bits of SharedSlave::report above the AL status byte.
constexpr std::uint32_t kValidBit = 0x100;
constexpr std::uint32_t kAbsentBit = 0x200;
constexpr std::uint32_t kWatchedBit = 0x400;
constexpr std::uint32_t kMailboxBit = 0x800;
constexpr std::uint32_t kOperationalBit = 0x1000;

// Bit positions in other_datagram_.
constexpr unsigned kWeightShift = 40;
constexpr unsigned kCommandShift = 32;
constexpr unsigned kAdpShift = 16;

}  // namespace

CyclicCore::CyclicCore(port::Port& port, rt::Clock& clock, ProcessImage image, motion::MotionControl* motion,
                       motion::SampleRings rings, Settings settings)
    : port_(port),
      clock_(clock),
      image_(std::move(image)),
      motion_(motion),
      rings_(rings),
      settings_(std::move(settings)),
      results_(image_.datagrams().size()),
      conditions_(image_.places().size()),
      before_(image_.places().size()),
      was_op_(image_.places().size()),
      slave_valid_(std::make_unique<bool[]>(image_.places().size())),
      slave_operational_(std::make_unique<bool[]>(image_.places().size())),
      slave_due_(std::make_unique<bool[]>(image_.places().size())),
      uneven_(std::any_of(image_.groups().begin(), image_.groups().end(),
                          [](const ExchangeGroupSettings& group) { return group.divider > 1; })),
      shared_(std::make_unique<SharedSlave[]>(image_.places().size())),
      group_count_(std::max<std::size_t>(1, image_.groups().size())),
      groups_(std::make_unique<ExchangeGroupCounters[]>(group_count_)),
      tallies_(group_count_),
      acyclic_(AcyclicChannel::kLostAfterCycles,
               settings_.acyclic_bytes != 0 ? settings_.acyclic_bytes
                                            : acyclic_bytes(image_, settings_.clocks != nullptr, settings_.period)),
      receive_wait_(settings_.receive_window) {
  const std::size_t frames = std::max<std::size_t>(1, image_.frame_count());
  frames_.reserve(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    frames_.emplace_back(image_, i, i == 0 && settings_.clocks != nullptr);
  }
  for (const auto& frame : frames_) {
    for (std::size_t i = 0; i < frame.results().size(); ++i) {
      results_[frame.first_datagram() + i] = &frame.results()[i];
    }
    if (!frame.results().empty()) tallies_[frame.group()].expected += frame.expected_working_counter();
  }
  for (auto& tally : tallies_) tally.last_working_counter = tally.expected;
}

void CyclicCore::cycle(const rt::CycleStart& start) noexcept {
  begin(start);
  send(start.grid);
  mark(motion::CyclePhase::kSend);
  receive();
  mark(motion::CyclePhase::kReceive);
  evaluate(start);
  grid_shift_ = {};
  if (settings_.clocks != nullptr && due(frames_.front())) {
    grid_shift_ = settings_.clocks->finish(start, sent_at_, frames_.front().drift());
  }
  mark(motion::CyclePhase::kJudge);
  const std::span<const bool> valid(slave_valid_.get(), conditions_.size());
  if (motion_ != nullptr) {
    motion_->read_inputs(image_.inputs(), valid, {slave_operational_.get(), conditions_.size()}, due_slaves(),
                         exchanged_at_ - start.wake, sent_at_ - start.grid);
  }
  mark(motion::CyclePhase::kInputs);
  if (settings_.tasks != nullptr) settings_.tasks->begin(start);
  run_tasks(motion::TaskTiming::Order::kBeforeMotion, start);
  mark(motion::CyclePhase::kTasksBefore);
  if (motion_ != nullptr) motion_->update(start.cycle, image_.outputs());
  mark(motion::CyclePhase::kMotion);
  run_tasks(motion::TaskTiming::Order::kAfterMotion, start);
  motion::apply_copies(settings_.copies, valid, image_.inputs(), image_.outputs());
  acyclic_.end_cycle();
  const auto done = clock_.now();
  if (settings_.trace != nullptr) settings_.trace->mark(motion::CyclePhase::kTasksAfter, done);
  const auto cost = done - start.wake;
  tally(start, cost);
  publish(start, cost);
  mark(motion::CyclePhase::kPublish);
  if (settings_.trace != nullptr && counting_) settings_.trace->end();
}

void CyclicCore::run_tasks(motion::TaskTiming::Order order, const rt::CycleStart& start) noexcept {
  if (settings_.tasks == nullptr) return;
  motion::TaskCycle now;
  now.cycle = start.cycle;
  now.grid = start.grid;
  if (settings_.clocks != nullptr) now.system_time_ns = settings_.clocks->system_time(start.grid);
  if (motion_ != nullptr) {
    now.axes = motion_->axes();
    now.setpoints = motion_->setpoints();
  }
  now.inputs = image_.inputs();
  now.valid = {slave_valid_.get(), conditions_.size()};
  now.outputs = image_.outputs();
  settings_.tasks->run(order, now, settings_.period, clock_);
}

void CyclicCore::remember_missing(std::uint32_t sequence) noexcept {
  missing_[next_missing_] = sequence;
  next_missing_ = (next_missing_ + 1) % missing_.size();
}

/// Matches a missing frame only once, so that a duplicate is not counted as late again.
bool CyclicCore::was_missing(std::uint32_t sequence) noexcept {
  const auto found = std::find(missing_.begin(), missing_.end(), sequence);
  if (found == missing_.end() || sequence == 0) return false;
  *found = 0;
  return true;
}

void CyclicCore::begin(const rt::CycleStart& start) noexcept {
  cycle_number_ = static_cast<std::uint64_t>(start.cycle);
  missed_now_ = static_cast<std::uint32_t>(start.missed);
  const auto settings = image_.groups();
  for (std::size_t i = 0; i < settings.size(); ++i) tallies_[i].due = settings[i].due(cycle_number_);
  if (recovery_requests_.load(std::memory_order_acquire) != recovery_requests_seen_) take_recovery_requests();
  take_counting();
  if (settings_.trace != nullptr) settings_.trace->begin(start, settings_.period);
  if (start.missed > 0) note_absence(start);
}

/// Runs before the absence is reported: if the report ends the counting, the late cycle still counts.
void CyclicCore::take_counting() noexcept {
  const auto switched = count_switched_.load(std::memory_order_acquire);
  if (switched == count_seen_) return;
  count_seen_ = switched;
  counting_ = counts(switched);
  if (!counting_) return;
  statistics_ = motion::CycleStatistics{};
  if (settings_.trace != nullptr) settings_.trace->clear();
  missing_.fill(0);
}

/// Runs before anything is sent: outputs prepared for a skipped cycle are no longer valid for the drives.
void CyclicCore::note_absence(const rt::CycleStart& start) noexcept {
  motion::MasterAbsence absence;
  absence.duration = start.late(settings_.period);
  absence.since = start.wake - absence.duration;
  absence.cycle = cycle_number_;
  if (motion_ != nullptr) {
    absence.effect = motion_->resume(start.cycle, start.missed, image_.outputs());
    prepared_ = false;
    absence.path_late = motion_->path_late();
  }
  absences_.try_push(absence);
}

/// Slaves that are exchanged in this cycle; empty: all.
std::span<const bool> CyclicCore::due_slaves() noexcept {
  if (!uneven_) return {};
  for (std::size_t i = 0; i < conditions_.size(); ++i) slave_due_[i] = tallies_[image_.places()[i].group].due;
  return {slave_due_.get(), conditions_.size()};
}

void CyclicCore::take_recovery_requests() noexcept {
  // Read the number first: a request that arrives meanwhile is then taken again in the next cycle instead of being
  // missed.
  recovery_requests_seen_ = recovery_requests_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    conditions_[i].recovering = shared_[i].recovering.load(std::memory_order_relaxed);
  }
  for (auto& tally : tallies_) tally.settled = false;
}

nanoseconds CyclicCore::first_grid(nanoseconds earliest) const noexcept {
  if (settings_.clocks != nullptr) return settings_.clocks->first_grid(earliest);
  // Without distributed clocks, drives that share the clock also run their control loops on multiples of the period.
  return (earliest + settings_.period - nanoseconds{1}) / settings_.period * settings_.period;
}

void CyclicCore::tally(const rt::CycleStart& start, nanoseconds cost) noexcept {
  cycles_shared_.store(++cycles_, std::memory_order_release);
  if (flooded_) flooded_cycles_.add();
  if (!counting_) return;
  statistics_.cycles += 1;
  statistics_.missed_periods += missed_now_;
  if (flooded_) ++statistics_.flooded_cycles;
  const auto late = start.late(settings_.period);
  rt::record_lateness(statistics_.wake_latency, late, start.missed, settings_.period);
  if (start.missed > 0 && late > statistics_.longest_absence) {
    statistics_.longest_absence = late;
    statistics_.longest_absence_at = start.wake - late;
  }
  statistics_.cost.record(cost);
  statistics_.master_cost.record(cost - (exchanged_at_ - start.wake));
  if (all_received()) statistics_.round_trip.record(received_at_ - sent_at_);
  for (const auto& frame : frames_) {
    if (!due(frame)) continue;
    if (!frame.received()) {
      ++statistics_.lost_frames;
      remember_missing(frame.tag().sequence);
    } else if (!frame.valid()) {
      ++statistics_.wkc_errors;
    }
  }
}

bool CyclicCore::due(const CyclicFrame& frame) const noexcept {
  return frame.results().empty() || tallies_[frame.group()].due;
}

bool CyclicCore::zeroed(const CyclicFrame& frame) const noexcept {
  return groups_[frame.group()].outputs_zeroed.load(std::memory_order_relaxed);
}

void CyclicCore::prepare() noexcept {
  for (auto& frame : frames_) frame.prepare(image_, zeroed(frame));
  prepared_ = true;
}

/// Sends the frames at the instant of the cycle, or at once if that has passed.
void CyclicCore::send(nanoseconds grid) noexcept {
  awaited_ = 0;
  unexpected_ = unexpected_late_ = 0;
  flooded_ = false;
  received_at_ = {};
  port_.hold_until(grid);
  for (auto& frame : frames_) {
    if (!due(frame)) continue;
    const bool first = &frame == &frames_.front();
    if (first && settings_.clocks != nullptr) frame.set_drift(settings_.clocks->next(std::max(clock_.now(), grid)));
    const bool zero = zeroed(frame);
    if (!prepared_ || zero != frame.outputs_are_zero()) frame.prepare(image_, zero);
    // A frame that could not be sent is counted as lost at the end of the cycle.
    static_cast<void>(frame.send(port_, FrameTag{settings_.instance, ++sequence_}));
    // The first frame is due less often than others if its group is.
    if (++awaited_ == 1) sent_at_ = port_.last_send_time();
  }
  prepared_ = false;
  // A late wake-up must not turn an answer in flight into a lost frame: wait for at least half the window.
  deadline_ = std::max(grid + settings_.receive_window, sent_at_ + settings_.receive_window / 2);
  take_what_is_back();
  sequence_ = acyclic_.send_due(port_, FrameTag{settings_.instance, sequence_}).sequence;
}

/// Acyclic frames come back after those of the cycle, so they are received in the next cycle: here if other frames wait
/// for them, while the cyclic frames are on the wire.
void CyclicCore::take_what_is_back() noexcept {
  while (acyclic_.awaits_round()) {
    const auto frame = port_.receive();
    if (!frame || !take(*frame)) return;
  }
}

/// Polls the port until all cyclic frames are back or the deadline has passed. Later frames in the queue wait for the
/// next cycle unless an acyclic answer is expected, because another poll costs a system call.
void CyclicCore::receive() noexcept {
  auto yielded_at = sent_at_;
  const bool slept = sleep_towards_answers();
  bool waited = false;
  // Poll once more after the deadline: a thread that was suspended meanwhile then finds the frames that have arrived.
  for (bool expired = false;;) {
    if (const auto frame = port_.receive()) {
      const bool more = take(*frame);
      exchanged_at_ = frame->time;
      if (!more) break;
      if (acyclic_.in_flight() || !all_received()) continue;
      break;
    }
    exchanged_at_ = clock_.now();
    if (expired || all_received()) break;
    expired = exchanged_at_ >= deadline_;
    if (expired) continue;
    waited = true;
    wait_on(yielded_at);
  }
  if (settings_.receive != ReceiveStrategy::kSleep || !all_received()) return;
  receive_wait_.returned(received_at_ - sent_at_);
  if (slept && !waited) receive_wait_.were_there(clock_.now() - sent_at_);
}

/// Returns whether it has slept.
bool CyclicCore::sleep_towards_answers() noexcept {
  if (settings_.receive != ReceiveStrategy::kSleep || all_received()) return false;
  const auto wake_at = receive_wait_.wake_at(sent_at_);
  if (!wake_at || *wake_at >= deadline_ || *wake_at <= clock_.now()) return false;
  clock_.sleep_until(*wake_at);
  receive_wait_.woke(*wake_at, clock_.now());
  return true;
}

/// One step of the wait for frames.
void CyclicCore::wait_on(nanoseconds& yielded_at) noexcept {
  if (settings_.receive == ReceiveStrategy::kBlock) {
    static_cast<void>(port_.wait_readable(deadline_));
    return;
  }
  // A simulated line on the same CPU, or the receiving thread of the kernel, answers only when it is scheduled.
  if (exchanged_at_ - yielded_at >= kYieldInterval) {
    yielded_at = exchanged_at_;
    clock_.yield();
  } else {
    clock_.spin();
  }
}

/// Handles a frame; false: receive no more in this cycle. Only an unexpected frame costs a look at the clock, as there
/// are no more expected ones than were sent.
bool CyclicCore::take(const port::ReceivedFrame& frame) noexcept {
  if (dispatch(frame)) return true;
  ++unexpected_;
  if (clock_.now() >= deadline_) ++unexpected_late_;
  const auto late_limit = kMostUnexpectedLate + frames_.size();
  flooded_ = unexpected_ >= kMostUnexpected || unexpected_late_ >= late_limit;
  return !flooded_;
}

/// Returns whether the frame was expected.
bool CyclicCore::dispatch(const port::ReceivedFrame& frame) noexcept {
  const bool complete = frame.bytes.size() >= wire::EthernetHeader::kSize;
  const auto tag = complete ? FrameTag::of(frame.bytes) : FrameTag{};
  if (!complete || tag.instance != settings_.instance) {
    note_foreign(frame.bytes);
    return false;
  }
  for (auto& cyclic : frames_) {
    if (cyclic.accept(frame.bytes, tag, image_, conditions_)) {
      received_at_ = frame.time;
      --awaited_;
      return true;
    }
  }
  if (acyclic_.accept(frame.bytes, tag)) return true;
  stale_frames_.add();
  if (!counting_) return false;
  ++statistics_.stale_frames;
  if (was_missing(tag.sequence)) ++statistics_.late_frames;
  return false;
}

void CyclicCore::note_foreign(std::span<const std::byte> frame) noexcept {
  if (harmless_guest(frame)) return;
  foreign_frames_.add();
  if (counting_) ++statistics_.foreign_frames;
  auto cursor = wire::DatagramCursor::open(frame);
  if (!cursor || cursor->done()) return;
  const auto datagram = cursor->next();
  if (!datagram) return;
  frames_of_masters_.add();
  std::array<std::byte, 8> source{};
  std::copy_n(frame.begin() + 6, 6, source.begin());
  other_source_.store(bytes::load_le<std::uint64_t>(source), std::memory_order_relaxed);
  const auto& header = datagram->header;
  const auto seen = std::uint64_t{harm_of(header.command, header.address.ado())} << kWeightShift |
                    std::uint64_t{static_cast<std::uint8_t>(header.command)} << kCommandShift |
                    std::uint64_t{header.address.adp()} << kAdpShift | header.address.ado();
  // Store the most serious datagram: a single write matters more than a thousand reads.
  const auto before = other_datagram_.load(std::memory_order_relaxed);
  if (seen >> kWeightShift >= before >> kWeightShift) other_datagram_.store(seen, std::memory_order_relaxed);
}

OtherMaster CyclicCore::other_master() const noexcept {
  OtherMaster other;
  other.frames = frames_of_masters_.value();
  const auto source = bytes::to_le_bytes(other_source_.load(std::memory_order_relaxed));
  std::copy_n(source.begin(), other.source.size(), other.source.begin());
  const auto seen = other_datagram_.load(std::memory_order_relaxed);
  other.command = static_cast<wire::Command>(seen >> kCommandShift & 0xFFU);
  other.adp = static_cast<std::uint16_t>(seen >> kAdpShift);
  other.ado = static_cast<std::uint16_t>(seen);
  return other;
}

void CyclicCore::note(CyclicEvent::Kind kind, std::size_t index, unsigned before, unsigned after,
                      const rt::CycleStart& start) noexcept {
  events_.try_push({kind, static_cast<std::uint16_t>(index), static_cast<std::uint16_t>(before),
                    static_cast<std::uint16_t>(after), cycle_number_, start.grid.count()});
}

/// Evaluates the validity of groups and slaves, and updates the values shared with other threads.
void CyclicCore::evaluate(const rt::CycleStart& start) noexcept {
  for (auto& frame : frames_) frame.judge_outputs(image_, conditions_);
  const auto line = frames_.front().al_status().value_or(LineAlStatus{});
  al_status_shared_.store((std::uint32_t{line.slaves} << 16) | line.combined, std::memory_order_relaxed);
  judge_groups(start);
  if (anything_new()) judge_slaves(start);
}

/// Returns false if no answer can differ from the previous one for any slave.
bool CyclicCore::anything_new() const noexcept {
  return std::any_of(frames_.begin(), frames_.end(), [this](const CyclicFrame& frame) {
    return !frame.results().empty() && tallies_[frame.group()].due &&
           !(frame.steady() && tallies_[frame.group()].settled);
  });
}

void CyclicCore::judge_slaves(const rt::CycleStart& start) noexcept {
  for (auto& tally : tallies_) tally.settled = tally.settled || tally.due;
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    auto& tally = tallies_[image_.places()[i].group];
    if (!tally.due) continue;
    const bool valid = judge_slave(i, start);
    tally.settled = tally.settled && valid;
  }
}

void CyclicCore::judge_groups(const rt::CycleStart& start) noexcept {
  for (auto& tally : tallies_) {
    tally.lost = 0;
    tally.incomplete = 0;
    tally.working_counter = 0;
  }
  for (const auto& frame : frames_) {
    if (!due(frame) || frame.results().empty()) continue;
    auto& tally = tallies_[frame.group()];
    if (!frame.received()) ++tally.lost;
    if (frame.received() && !frame.valid()) ++tally.incomplete;
    tally.working_counter += frame.working_counter();
  }
  bool all_valid = frames_.front().received();
  for (std::size_t i = 0; i < tallies_.size(); ++i) {
    if (tallies_[i].due) judge_group(i, start);
    all_valid = all_valid && groups_[i].bad_cycles.load(std::memory_order_relaxed) == 0;
  }
  bad_cycles_.store(all_valid ? 0 : bad_cycles_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

void CyclicCore::judge_group(std::size_t number, const rt::CycleStart& start) noexcept {
  auto& tally = tallies_[number];
  auto& counters = groups_[number];
  counters.exchanges.add();
  counters.lost_frames.add(tally.lost);
  counters.wkc_errors.add(tally.incomplete);
  counters.working_counter.store(tally.working_counter, std::memory_order_relaxed);
  if (tally.lost > 0) {
    note(CyclicEvent::Kind::kFrameLost, number, 0, tally.lost, start);
  } else if (tally.working_counter != tally.last_working_counter) {
    note(CyclicEvent::Kind::kWorkingCounter, number, tally.expected, tally.working_counter, start);
    tally.last_working_counter = tally.working_counter;
  }
  if (tally.lost + tally.incomplete == 0) {
    counters.bad_cycles.store(0, std::memory_order_relaxed);
    return;
  }
  const auto bad = counters.bad_cycles.load(std::memory_order_relaxed) + 1;
  counters.bad_cycles.store(bad, std::memory_order_relaxed);
  if (bad > counters.longest_bad.load(std::memory_order_relaxed)) {
    counters.longest_bad.store(bad, std::memory_order_relaxed);
  }
  const auto limit = number < image_.groups().size() ? image_.groups()[number].bad_cycle_limit : 0U;
  if (limit == 0 || bad < limit || counters.outputs_zeroed.load(std::memory_order_relaxed)) return;
  counters.outputs_zeroed.store(true, std::memory_order_relaxed);
  note(CyclicEvent::Kind::kOutputsZeroed, number, limit, bad, start);
}

/// Whether the datagram came back with the working counter of all present slaves; also true for kNone (no datagram).
bool CyclicCore::carried(std::size_t datagram) const noexcept {
  return datagram == ProcessDataPlace::kNone || results_[datagram]->good;
}

/// Returns whether the slave is valid.
bool CyclicCore::judge_slave(std::size_t slave, const rt::CycleStart& start) noexcept {
  const auto& place = image_.places()[slave];
  auto& condition = conditions_[slave];
  auto& before = before_[slave];
  const bool watched = place.al_status_offset != ProcessDataPlace::kNone;
  const bool status_read = watched && results_[place.input_datagram]->received;
  if (status_read && condition.al_status != before.al_status) {
    note(CyclicEvent::Kind::kSlaveState, slave, before.al_status, condition.al_status, start);
    before.al_status = condition.al_status;
  }
  if (status_read && in_op(condition.al_status)) was_op_[slave] = 1;
  // A slave that has left OP still provides inputs, but does not take its outputs.
  const bool fallen = watched && was_op_[slave] != 0 && !in_op(condition.al_status);
  const bool valid = carried(place.output_datagram) && carried(place.input_datagram) && !condition.absent &&
                     !condition.down && !condition.recovering;
  slave_valid_[slave] = valid;
  slave_operational_[slave] = valid && !fallen;
  auto& shared = shared_[slave];
  shared.stale.store(valid ? 0 : shared.stale.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  std::uint32_t report = condition.al_status;
  if (valid) report |= kValidBit;
  if (valid && !fallen) report |= kOperationalBit;
  if (condition.absent) report |= kAbsentBit;
  if (watched) report |= kWatchedBit;
  if (place.mailbox_offset != ProcessDataPlace::kNone &&
      (std::to_integer<unsigned>(image_.inputs()[place.mailbox_offset]) & wire::SyncManagerStatus::kMailboxFull) != 0) {
    report |= kMailboxBit;
  }
  shared.report.store(report, std::memory_order_release);
  return valid;
}

CyclicCore::SlaveReport CyclicCore::slave_report(std::size_t slave) const noexcept {
  const auto raw = shared_[slave].report.load(std::memory_order_acquire);
  SlaveReport report;
  report.al_status = static_cast<std::uint8_t>(raw & 0xFF);
  report.valid = (raw & kValidBit) != 0;
  report.operational = (raw & kOperationalBit) != 0;
  report.absent = (raw & kAbsentBit) != 0;
  report.watched = (raw & kWatchedBit) != 0;
  report.mailbox_full = (raw & kMailboxBit) != 0;
  report.stale_exchanges = shared_[slave].stale.load(std::memory_order_relaxed);
  return report;
}

snapshot::LineSample CyclicCore::line_sample(const rt::CycleStart& start, nanoseconds cost) const noexcept {
  snapshot::LineSample line;
  line.cycle = static_cast<std::uint64_t>(start.cycle);
  line.time_ns = start.grid.count();
  line.wake_latency_ns = start.late(settings_.period).count();
  line.cost_ns = cost.count();
  line.round_trip_ns = all_received() ? (received_at_ - sent_at_).count() : 0;
  line.missed_periods = missed_now_;
  if (settings_.clocks != nullptr) {
    line.dc_locked = settings_.clocks->locked();
    line.dc_difference_ns = settings_.clocks->last_error().count();
  }
  for (const auto& frame : frames_) {
    if (!due(frame)) continue;
    line.working_counter = static_cast<std::uint16_t>(line.working_counter + frame.working_counter());
    // Working counter of the slaves that are expected now.
    const auto expected = frame.valid() ? frame.working_counter() : frame.expected_working_counter();
    line.expected_working_counter = static_cast<std::uint16_t>(line.expected_working_counter + expected);
  }
  line.frame_received = all_received();
  line.axes = motion_ != nullptr ? static_cast<std::uint16_t>(motion_->axes().size()) : std::uint16_t{0};
  return line;
}

void CyclicCore::publish(const rt::CycleStart& start, nanoseconds cost) noexcept {
  const bool sampled = rings_.lines != nullptr && start.cycle % settings_.sample_every == 0;
  if (!sampled && settings_.recorder == nullptr) return;
  const auto line = line_sample(start, cost);
  if (settings_.recorder != nullptr) record(line);
  if (!sampled) return;
  rings_.lines->try_push(line);
  if (rings_.axes == nullptr || motion_ == nullptr) return;
  motion::publish(*motion_, line, *rings_.axes);
}

/// Whether the process data of a group have now been bad for so many exchanges that the recorder is triggered.
bool CyclicCore::turned_bad_for_long() const noexcept {
  constexpr std::uint32_t kBadExchanges = 8;
  if (!uneven_) return bad_cycles_.load(std::memory_order_relaxed) == kBadExchanges;
  for (std::size_t i = 0; i < group_count_; ++i) {
    if (tallies_[i].due && groups_[i].bad_cycles.load(std::memory_order_relaxed) == kBadExchanges) return true;
  }
  return false;
}

/// Triggers the recorder when the motion has failed, or when process data have been bad for long.
void CyclicCore::record(const snapshot::LineSample& line) noexcept {
  std::span<const motion::Axis> axes;
  if (motion_ != nullptr) {
    axes = motion_->axes();
    const bool failed = motion_->failed();
    if (failed && !failure_recorded_) settings_.recorder->trigger();
    failure_recorded_ = failed;
  }
  if (turned_bad_for_long()) settings_.recorder->trigger();
  settings_.recorder->record(line, axes);
}

}  // namespace driveline::ecat_master
