#include "driveline/ecat_master/cyclic/cyclic_core.hpp"

#include <algorithm>

#include "driveline/ecat_master/cyclic/acyclic_budget.hpp"

namespace driveline::ecat_master {

using std::chrono::nanoseconds;

namespace {

/// Interval at which a wait for frames yields the CPU to threads of the same priority.
constexpr nanoseconds kYieldInterval = std::chrono::microseconds{25};

/// Makes the frames of the cycle; the first one carries the drift compensation of the clocks if there are any.
std::vector<CyclicFrame> make_frames(const ProcessImage& image, bool clocks) {
  const std::size_t count = std::max<std::size_t>(1, image.frame_count());
  std::vector<CyclicFrame> frames;
  frames.reserve(count);
  for (std::size_t i = 0; i < count; ++i) frames.emplace_back(image, i, i == 0 && clocks);
  return frames;
}

}  // namespace

CyclicCore::CyclicCore(port::Port& port, rt::Clock& clock, ProcessImage image, motion::MotionControl* motion,
                       motion::SampleRings rings, Settings settings)
    : port_(port),
      clock_(clock),
      image_(std::move(image)),
      motion_(motion),
      settings_(std::move(settings)),
      record_({settings_.period, settings_.sample_every, rings, settings_.recorder, settings_.trace}),
      frames_(make_frames(image_, settings_.clocks != nullptr)),
      judge_(image_, frames_),
      acyclic_(AcyclicChannel::kLostAfterCycles,
               settings_.acyclic_bytes != 0 ? settings_.acyclic_bytes
                                            : acyclic_bytes(image_, settings_.clocks != nullptr, settings_.period)),
      receive_wait_(settings_.receive_window) {}

void CyclicCore::cycle(const rt::CycleStart& start) noexcept {
  begin(start);
  send(start.grid);
  record_.mark(motion::CyclePhase::kSend, clock_);
  receive();
  record_.mark(motion::CyclePhase::kReceive, clock_);
  judge_.evaluate(start);
  grid_shift_ = {};
  if (settings_.clocks != nullptr && judge_.due(frames_.front())) {
    grid_shift_ = settings_.clocks->finish(start, sent_at_, frames_.front().drift());
  }
  record_.mark(motion::CyclePhase::kJudge, clock_);
  if (motion_ != nullptr) {
    motion_->read_inputs(image_.inputs(), judge_.valid(), judge_.operational(), judge_.due_slaves(),
                         exchanged_at_ - start.wake, sent_at_ - start.grid);
  }
  record_.mark(motion::CyclePhase::kInputs, clock_);
  if (settings_.tasks != nullptr) settings_.tasks->begin(start);
  run_tasks(motion::TaskTiming::Order::kBeforeMotion, start);
  record_.mark(motion::CyclePhase::kTasksBefore, clock_);
  if (motion_ != nullptr) motion_->update(start.cycle, image_.outputs());
  record_.mark(motion::CyclePhase::kMotion, clock_);
  run_tasks(motion::TaskTiming::Order::kAfterMotion, start);
  motion::apply_copies(settings_.copies, judge_.valid(), image_.inputs(), image_.outputs());
  acyclic_.end_cycle();
  record_.add(start, clock_.now(), exchanged_at_ - start.wake);
  tally();
  if (record_.wants_sample(start)) record_.publish(start, line_sample(start), motion_, judge_.turned_bad_for_long());
  record_.end(clock_);
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
  now.valid = judge_.valid();
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
  judge_.begin(static_cast<std::uint64_t>(start.cycle));
  if (record_.begin(start)) missing_.fill(0);
  if (start.missed > 0) {
    record_.absence(start, motion_, image_.outputs());
    if (motion_ != nullptr) prepared_ = false;
  }
}

nanoseconds CyclicCore::first_grid(nanoseconds earliest) const noexcept {
  if (settings_.clocks != nullptr) return settings_.clocks->first_grid(earliest);
  // Without distributed clocks, drives that share the clock also run their control loops on multiples of the period.
  return (earliest + settings_.period - nanoseconds{1}) / settings_.period * settings_.period;
}

void CyclicCore::tally() noexcept {
  if (flooded_) flooded_cycles_.add();
  if (!record_.counting()) return;
  auto& counters = record_.counters();
  if (flooded_) ++counters.flooded_cycles;
  if (all_received()) counters.round_trip.record(received_at_ - sent_at_);
  for (const auto& frame : frames_) {
    if (!judge_.due(frame)) continue;
    if (!frame.received()) {
      ++counters.lost_frames;
      remember_missing(frame.tag().sequence);
    } else if (!frame.valid()) {
      ++counters.wkc_errors;
    }
  }
}

void CyclicCore::prepare() noexcept {
  for (auto& frame : frames_) frame.prepare(image_, judge_.zeroed(frame));
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
    if (!judge_.due(frame)) continue;
    const bool first = &frame == &frames_.front();
    if (first && settings_.clocks != nullptr) frame.set_drift(settings_.clocks->next(std::max(clock_.now(), grid)));
    const bool zero = judge_.zeroed(frame);
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
    if (foreign_.note(frame.bytes) && record_.counting()) ++record_.counters().foreign_frames;
    return false;
  }
  for (auto& cyclic : frames_) {
    if (cyclic.accept(frame.bytes, tag, image_, judge_.conditions())) {
      received_at_ = frame.time;
      --awaited_;
      return true;
    }
  }
  if (acyclic_.accept(frame.bytes, tag)) return true;
  stale_frames_.add();
  if (!record_.counting()) return false;
  ++record_.counters().stale_frames;
  if (was_missing(tag.sequence)) ++record_.counters().late_frames;
  return false;
}

snapshot::LineSample CyclicCore::line_sample(const rt::CycleStart& start) const noexcept {
  snapshot::LineSample line;
  record_.fill(start, motion_, line);
  line.round_trip_ns = all_received() ? (received_at_ - sent_at_).count() : 0;
  if (settings_.clocks != nullptr) {
    line.dc_locked = settings_.clocks->locked();
    line.dc_difference_ns = settings_.clocks->last_error().count();
  }
  for (const auto& frame : frames_) {
    if (!judge_.due(frame)) continue;
    line.working_counter = static_cast<std::uint16_t>(line.working_counter + frame.working_counter());
    // Working counter of the slaves that are expected now.
    const auto expected = frame.valid() ? frame.working_counter() : frame.expected_working_counter();
    line.expected_working_counter = static_cast<std::uint16_t>(line.expected_working_counter + expected);
  }
  line.frame_received = all_received();
  return line;
}

}  // namespace driveline::ecat_master
