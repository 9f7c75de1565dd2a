#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"

#include <algorithm>

#include "driveline/wire/frame.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::ecat_master {
namespace {

/// Whether all slaves took what was written to them.
bool writes_taken(std::span<const std::byte> frame) noexcept {
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) return false;
    if (datagram->header.command == wire::Command::kFpwr && datagram->working_counter() == 0) return false;
  }
  return cursor.has_value();
}

}  // namespace

// The ring of answers holds as many frames as the ring of requests and the wire together.
AcyclicChannel::AcyclicChannel(std::uint32_t lost_after_cycles, std::size_t bytes_per_cycle)
    : requests_(kMaxFrames),
      answers_(2 * kMaxFrames),
      lost_after_cycles_(lost_after_cycles),
      bytes_per_cycle_(std::clamp(bytes_per_cycle, wire::kMinFrameBytes, kMaxBytes)) {}

FrameTag AcyclicChannel::send_due(port::Port& port, FrameTag last) noexcept {
  // Save bytes only for the one frame that needs them: a burst of other frames would delay the next cycle.
  credit_ = std::min(credit_ + bytes_per_cycle_,
                     saving_ ? std::max(port::kMaxFrameBytes, bytes_per_cycle_) : bytes_per_cycle_);
  saving_ = false;
  std::size_t gap = 0;
  while (auto* flight = next_waiting()) {
    const auto& job = flight->job;
    if (may_not_go(job)) {
      withhold(*flight);
      continue;
    }
    if (must_wait(job)) break;
    saving_ = job.size + gap > credit_;
    if (saving_) break;
    credit_ -= job.size + gap;
    ++last.sequence;
    take_off(*flight, last, port);
    // Cost of every further frame on the wire besides its bytes; the budget includes it for one frame.
    gap = wire::kPreambleFcsGap;
  }
  return last;
}

void AcyclicChannel::take_off(Flight& flight, FrameTag tag, port::Port& port) noexcept {
  auto& job = flight.job;
  if (job.round != 0) {
    if (job.round != round_.number) round_ = {.number = job.round};
    ++round_.flying;
  }
  const auto mac = tag.to_mac();
  std::copy(mac.begin(), mac.end(), job.bytes.begin() + 6);
  flight.tag = tag;
  flight.age = 0;
  // A frame that could not be sent counts as lost.
  flight.state = Flight::State::kFlying;
  waiting_ = nullptr;
  ++flying_;
  static_cast<void>(port.send(std::span(job.bytes).first(job.size)));
}

/// Whether the frame depends on a round that is not over. Its own round has started if another frame of it was sent.
bool AcyclicChannel::must_wait(const AcyclicJob& job) const noexcept {
  return job.behind != 0 && job.round != round_.number && round_.flying != 0;
}

bool AcyclicChannel::may_not_go(const AcyclicJob& job) const noexcept {
  if (job.behind == 0) return false;
  const bool known = job.round == round_.number || job.behind == round_.number;
  return !known || !round_.good;
}

bool AcyclicChannel::awaits_round() noexcept {
  const auto* flight = next_waiting();
  return flight != nullptr && must_wait(flight->job) && !may_not_go(flight->job);
}

/// Frames that depend on a withheld frame must not be sent either.
void AcyclicChannel::withhold(Flight& flight) noexcept {
  if (flight.job.round != round_.number) round_ = {.number = flight.job.round};
  round_.good = false;
  waiting_ = nullptr;
  flight.state = Flight::State::kFree;
  flight.job.withheld = true;
  answers_.try_push(flight.job);
}

/// The frame to send next, from the ring if none waits; null: there is none, or too many are in flight.
AcyclicChannel::Flight* AcyclicChannel::next_waiting() noexcept {
  if (waiting_ != nullptr || flying_ == flights_.size()) return waiting_;
  const auto free =
      std::find_if(flights_.begin(), flights_.end(), [](const auto& one) { return one.state == Flight::State::kFree; });
  if (!requests_.try_pop(free->job)) return nullptr;
  free->state = Flight::State::kWaiting;
  waiting_ = &*free;
  return waiting_;
}

void AcyclicChannel::end(Flight& flight, bool answered) noexcept {
  auto& job = flight.job;
  job.answered = answered;
  flight.state = Flight::State::kFree;
  --flying_;
  if (job.round != 0 && job.round == round_.number) {
    --round_.flying;
    round_.good = round_.good && answered && writes_taken(std::span<const std::byte>(job.bytes).first(job.size));
  }
  answers_.try_push(job);
}

bool AcyclicChannel::accept(std::span<const std::byte> frame, FrameTag tag) noexcept {
  if (flying_ == 0) return false;
  const auto found = std::find_if(flights_.begin(), flights_.end(), [tag](const auto& one) {
    return one.state == Flight::State::kFlying && one.tag == tag;
  });
  if (found == flights_.end() || frame.size() < found->job.size) return false;
  std::copy_n(frame.begin(), found->job.size, found->job.bytes.begin());
  end(*found, true);
  return true;
}

void AcyclicChannel::end_cycle() noexcept {
  if (flying_ == 0) return;
  for (auto& flight : flights_) {
    if (flight.state == Flight::State::kFlying && ++flight.age >= lost_after_cycles_) end(flight, false);
  }
}

}  // namespace driveline::ecat_master
