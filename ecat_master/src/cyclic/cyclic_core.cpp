#include "driveline/ecat_master/cyclic/cyclic_core.hpp"

#include <algorithm>

namespace driveline::ecat_master {

using std::chrono::nanoseconds;

CyclicCore::CyclicCore(port::Port& port, rt::Clock& clock, ProcessImage image, Motion* motion, SampleRings rings,
                       Settings settings)
    : port_(port),
      clock_(clock),
      image_(std::move(image)),
      motion_(motion),
      rings_(rings),
      settings_(settings),
      slave_valid_(std::make_unique<bool[]>(image_.places().size())) {
  for (const auto& segment : image_.segments()) frames_.emplace_back(&segment, frames_.empty());
  if (frames_.empty()) frames_.emplace_back(nullptr, true);
}

void CyclicCore::cycle(const rt::CycleStart& start) noexcept {
  in_port_ = {};
  missed_now_ = static_cast<std::uint32_t>(start.missed);
  send();
  // A late wake-up must not turn an answer that is on its way into a lost frame: half the window is always waited.
  receive(std::max(start.grid + settings_.receive_window, sent_at_ + settings_.receive_window / 2));
  evaluate();
  if (motion_ != nullptr) {
    motion_->read_inputs(image_.inputs(), {slave_valid_.get(), image_.places().size()});
    motion_->update(start.cycle, image_.outputs());
  }
  acyclic_.end_cycle();
  const auto cost = clock_.now() - start.wake;
  tally(start, cost);
  publish(start, cost);
}

void CyclicCore::tally(const rt::CycleStart& start, nanoseconds cost) noexcept {
  cycles_shared_.store(++cycles_, std::memory_order_relaxed);
  if (const bool wanted = counting_wanted_.load(std::memory_order_acquire); wanted != counting_) {
    counting_ = wanted;
    if (counting_) statistics_ = CycleStatistics{};
  }
  if (!counting_) return;
  statistics_.cycles += 1;
  statistics_.missed_periods += missed_now_;
  statistics_.wake_latency.record(start.wake - start.grid);
  statistics_.cost.record(cost);
  statistics_.master_cost.record(cost - in_port_);
  if (all_received()) statistics_.round_trip.record(received_at_ - sent_at_);
  for (const auto& frame : frames_) {
    if (!frame.received()) {
      ++statistics_.lost_frames;
    } else if (!frame.valid()) {
      ++statistics_.wkc_errors;
    }
  }
}

void CyclicCore::send() noexcept {
  const auto begin = clock_.now();
  for (auto& frame : frames_) {
    // What could not be sent does not come back and is counted as lost at the end of the cycle.
    static_cast<void>(frame.send(port_, image_, FrameTag{settings_.instance, ++sequence_}));
    if (&frame == &frames_.front()) sent_at_ = port_.last_send_time();
  }
  acyclic_.send_next(port_, FrameTag{settings_.instance, ++sequence_});
  in_port_ += clock_.now() - begin;
}

bool CyclicCore::all_received() const noexcept {
  return std::all_of(frames_.begin(), frames_.end(), [](const CyclicFrame& f) { return f.received(); });
}

/// Polls the port until all cyclic frames are back or the deadline has passed, then takes what else is there.
void CyclicCore::receive(nanoseconds deadline) noexcept {
  const auto begin = clock_.now();
  received_at_ = {};
  // Once more after the deadline: whoever was held up in between finds what has arrived meanwhile.
  for (bool expired = false;;) {
    if (const auto frame = port_.receive()) {
      dispatch(*frame);
      continue;
    }
    if (expired || all_received()) break;
    expired = clock_.now() >= deadline;
    if (!expired) clock_.spin();
  }
  in_port_ += clock_.now() - begin;
}

void CyclicCore::dispatch(const port::ReceivedFrame& frame) noexcept {
  const auto ethernet = wire::EthernetHeader::decode(frame.bytes);
  const auto tag = ethernet ? FrameTag::from_mac(ethernet->source) : FrameTag{};
  if (!ethernet || tag.instance != settings_.instance) {
    ++statistics_.foreign_frames;
    return;
  }
  for (auto& cyclic : frames_) {
    if (cyclic.accept(frame.bytes, tag, image_)) {
      received_at_ = frame.time;
      return;
    }
  }
  if (!acyclic_.accept(frame.bytes, tag)) ++statistics_.stale_frames;
}

/// Validity per slave, and what other threads want to know at once.
void CyclicCore::evaluate() noexcept {
  const bool all_valid = std::all_of(frames_.begin(), frames_.end(), [](const CyclicFrame& f) { return f.valid(); });
  const auto& status = frames_.front().al_status();
  const auto line = status.value_or(LineAlStatus{});
  al_status_shared_.store((std::uint32_t{line.slaves} << 16) | line.combined, std::memory_order_relaxed);
  bad_cycles_.store(all_valid ? 0 : bad_cycles_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  const auto places = image_.places();
  for (std::size_t i = 0; i < places.size(); ++i) {
    slave_valid_[i] = places[i].segment < frames_.size() && frames_[places[i].segment].valid();
  }
}

void CyclicCore::publish(const rt::CycleStart& start, nanoseconds cost) noexcept {
  if (rings_.lines == nullptr || start.cycle % settings_.sample_every != 0) return;
  snapshot::LineSample line;
  line.cycle = static_cast<std::uint64_t>(start.cycle);
  line.time_ns = start.grid.count();
  line.wake_latency_ns = (start.wake - start.grid).count();
  line.cost_ns = cost.count();
  line.round_trip_ns = all_received() ? (received_at_ - sent_at_).count() : 0;
  line.missed_periods = missed_now_;
  for (const auto& frame : frames_) {
    line.working_counter = static_cast<std::uint16_t>(line.working_counter + frame.working_counter());
    line.expected_working_counter =
        static_cast<std::uint16_t>(line.expected_working_counter + frame.expected_working_counter());
  }
  line.frame_received = all_received();
  line.axes = motion_ != nullptr ? static_cast<std::uint16_t>(motion_->axes().size()) : std::uint16_t{0};
  rings_.lines->try_push(line);
  if (rings_.axes == nullptr || motion_ == nullptr) return;
  for (std::size_t i = 0; i < motion_->axes().size(); ++i) {
    snapshot::AxisSample sample;
    sample.cycle = line.cycle;
    sample.time_ns = line.time_ns;
    sample.axis = static_cast<std::uint16_t>(i);
    motion_->axes()[i].fill(sample);
    rings_.axes->try_push(sample);
  }
}

}  // namespace driveline::ecat_master
