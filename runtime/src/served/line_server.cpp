#include "driveline/runtime/served/line_server.hpp"

#include <algorithm>
#include <utility>

#include "driveline/wire/ethernet.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

/// Longest sleep without a frame, because the control loops of the drives must continue. It divides no usual cycle (a
/// multiple of 125 us); otherwise firmware steps and frames would coincide.
constexpr auto kIdleStep = microseconds{90};
/// A drive takes about 0.4 us per step, so that a frame waits a few microseconds at most.
constexpr std::size_t kSlavesAtATime = 16;
/// Interval at which states, commands and windows are handled.
constexpr auto kHousekeeping = microseconds{500};
/// Frames less than this apart belong to the same cycle of the master.
constexpr auto kBurstGap = microseconds{20};
/// A master without frames for this long is gone: no more busy polling.
constexpr auto kMasterGone = std::chrono::milliseconds{20};
constexpr auto kLongestRest = std::chrono::milliseconds{1};

void count(std::atomic<std::uint64_t>& counter) noexcept {
  // There is only one writer: load and store suffice.
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

/// Whether a clock of a slave has an event (SYNC0, SYNC1) by `time` that the slave has not processed yet.
bool instant_due(const slaves::SimulatedLine& line, nanoseconds time) noexcept {
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line.slave(i).esc().clock().sync_due() <= time) return true;
  }
  return false;
}

}  // namespace

LineServer::LineServer(slaves::SimulatedLine& line, port::Port& primary, port::Port* secondary, rt::Clock& clock,
                       Settings settings)
    : line_(line),
      ports_{&primary, secondary},
      clock_(clock),
      settings_(std::move(settings)),
      held_(kMaxHeld),
      orders_(line) {}

void LineServer::run(std::stop_token stop) noexcept {
  while (!stop.stop_requested()) {
    const auto next = turn();
    const auto now = clock_.now();
    if (next <= now) continue;
    if (settings_.busy_poll && now - last_frame_ < kMasterGone) {
      rest(std::min(next, now + interval_ / 8));
    } else if (settings_.wait) {
      settings_.wait(next);
    } else {
      ports_[0]->wait_readable(next);
    }
  }
}

void LineServer::rest(Nanoseconds until) noexcept {
  // Linux suspends a real-time thread that never sleeps, so sleep once per cycle of the master, right after its frames,
  // when the next frame is farthest away.
  if (std::exchange(rested_, true)) return;
  clock_.sleep_until(until);
}

LineServer::Nanoseconds LineServer::turn() noexcept {
  // The slaves react at once to the data of a frame.
  round_wanted_ |= serve_ports();
  const auto now = clock_.now();
  if (held_count_ > 0) release_held(now);
  if (now >= next_housekeeping_) housekeep(now);
  advance_some(now);
  if (next_slave_ > 0 || round_wanted_) return now;
  const auto next = std::min(next_round_, line_.faults().due());
  return held_count_ > 0 ? std::min(next, held_[first_held_].due) : next;
}

bool LineServer::serve_ports() noexcept {
  bool served = false;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i] == nullptr) continue;
    const auto frame = ports_[i]->receive();
    if (!frame) continue;
    serve(*frame, i);
    served = true;
  }
  return served;
}

void LineServer::advance_some(Nanoseconds now) noexcept {
  if (next_slave_ == 0) {
    if (!round_wanted_ && now < std::min(next_round_, line_.faults().due())) return;
    round_wanted_ = false;
    next_round_ = now + kIdleStep;
  }
  line_.advance_some(next_slave_, kSlavesAtATime, now);
  next_slave_ += kSlavesAtATime;
  if (next_slave_ >= line_.size()) next_slave_ = 0;
}

void LineServer::serve(const port::ReceivedFrame& frame, std::size_t port) noexcept {
  if (settings_.busy_poll) {
    if (frame.time - last_frame_ > kBurstGap) {
      interval_ = std::min<Nanoseconds>(frame.time - burst_begin_, 8 * kLongestRest);
      burst_begin_ = frame.time;
      rested_ = false;
    }
    last_frame_ = frame.time;
  }
  // The answer is as long as the request, but at least the shortest Ethernet frame, to which a real sender pads.
  const auto length = std::min(frame.bytes.size(), buffer_.size());
  const auto answer = std::span(buffer_).first(std::max(length, wire::kMinFrameBytes));
  std::fill(std::copy_n(frame.bytes.begin(), length, answer.begin()), answer.end(), std::byte{0});
  // Advance slaves that lag behind before the frame passes them: otherwise a SYNC event before the frame would use its
  // outputs, and the event after the frame would have none. Slaves lag when this thread did not run.
  if (frame.time > next_round_ + kIdleStep || instant_due(line_, frame.time)) line_.advance(frame.time);
  const auto passage = line_.pass(answer, frame.time, static_cast<slaves::MasterPort>(port));
  if (!passage) return;
  const auto exit = static_cast<std::size_t>(passage->exit);
  const bool late = passage->fault_delay > Nanoseconds{0};
  for (unsigned copy = 0; copy < (passage->duplicated ? 2U : 1U); ++copy) {
    if (late || held_count_ > 0) {
      hold(answer, exit, frame.time + passage->fault_delay);
    } else {
      reply(answer, exit);
      if (copy == 0) windows_[filled_].record(clock_.now() - frame.time);
    }
  }
}

void LineServer::reply(std::span<const std::byte> frame, std::size_t port) noexcept {
  if (ports_[port] == nullptr) return;
  const auto status = ports_[port]->send(frame);
  count(frames_);
  if (status != port::SendStatus::kSent) count(send_failures_);
}

void LineServer::hold(std::span<const std::byte> frame, std::size_t port, Nanoseconds due) noexcept {
  if (held_count_ == kMaxHeld) {
    count(send_failures_);
    return;
  }
  auto& place = held_[(first_held_ + held_count_) % kMaxHeld];
  std::copy(frame.begin(), frame.end(), place.bytes.begin());
  place.length = frame.size();
  place.port = port;
  // Frames do not overtake each other on a wire.
  const auto& before = held_[(first_held_ + held_count_ + kMaxHeld - 1) % kMaxHeld];
  place.due = held_count_ == 0 ? due : std::max(due, before.due);
  ++held_count_;
}

void LineServer::release_held(Nanoseconds now) noexcept {
  while (held_count_ > 0 && held_[first_held_].due <= now) {
    const auto& place = held_[first_held_];
    reply(std::span(place.bytes).first(place.length), place.port);
    first_held_ = (first_held_ + 1) % kMaxHeld;
    --held_count_;
  }
}

void LineServer::housekeep(Nanoseconds now) noexcept {
  next_housekeeping_ = now + kHousekeeping;
  orders_.carry_out(now);
  orders_.watch_states();
  // Acquire pairs with the release by the owner; the store below passes the finished window to the owner.
  if (window_.load(std::memory_order_acquire) == Window::kWanted) {
    filled_ ^= 1U;
    window_.store(Window::kReady, std::memory_order_release);
  }
}

void LineServer::request_window() noexcept {
  auto none = Window::kNone;
  window_.compare_exchange_strong(none, Window::kWanted, std::memory_order_acq_rel);
}

bool LineServer::take_window(rt::Histogram& window) noexcept {
  if (window_.load(std::memory_order_acquire) != Window::kReady) return false;
  window = windows_[taken_];
  windows_[taken_].reset();
  taken_ ^= 1U;
  taken_windows_.merge(window);
  window_.store(Window::kNone, std::memory_order_release);
  return true;
}

rt::Histogram LineServer::turn_around() const noexcept {
  auto all = taken_windows_;
  all.merge(windows_[0]);
  all.merge(windows_[1]);
  return all;
}

}  // namespace driveline::runtime
