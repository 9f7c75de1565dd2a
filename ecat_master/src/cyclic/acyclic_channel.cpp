#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"

#include <algorithm>
#include <utility>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::ecat_master {
namespace {

/// Two more than without a cycle: tries follow one another within cycles here, and a disturbance may last for some.
constexpr int kRetries = 6;
constexpr auto kAnswerTimeout = std::chrono::milliseconds{100};
/// A small part of the shortest cycle: an answer that is seen before the next cycle lets the next frame leave in it.
constexpr auto kPollInterval = std::chrono::microseconds{20};
constexpr std::size_t kLongestFrame = wire::EthernetHeader::kSize + wire::kMaxPayloadBytes;

}  // namespace

// As many answers as there can be frames in the ring and on the wire.
AcyclicChannel::AcyclicChannel(std::uint32_t lost_after_cycles, std::size_t bytes_per_cycle)
    : requests_(kMostFrames),
      answers_(2 * kMostFrames),
      lost_after_cycles_(lost_after_cycles),
      bytes_per_cycle_(std::clamp(bytes_per_cycle, wire::kMinFrameBytes, port::kMaxFrameBytes)) {}

FrameTag AcyclicChannel::send_due(port::Port& port, FrameTag last) noexcept {
  // Bytes are saved for the one frame that needs them: a burst of others would delay the next cycle.
  credit_ = std::min(credit_ + bytes_per_cycle_, waiting_ != nullptr ? port::kMaxFrameBytes : bytes_per_cycle_);
  std::size_t gap = 0;
  while (auto* flight = next_waiting()) {
    auto& job = flight->job;
    if (job.size + gap > credit_) break;
    credit_ -= job.size + gap;
    ++last.sequence;
    const auto mac = last.to_mac();
    std::copy(mac.begin(), mac.end(), job.bytes.begin() + 6);
    flight->tag = last;
    flight->age = 0;
    // A frame that could not be sent is treated as lost.
    flight->state = Flight::State::kFlying;
    waiting_ = nullptr;
    ++flying_;
    static_cast<void>(port.send(std::span(job.bytes).first(job.size)));
    // What every further frame costs on the wire besides its bytes; the budget has it for one.
    gap = wire::kPreambleFcsGap;
  }
  return last;
}

/// The frame to send next, from the ring when none waits; null: there is none, or too many are on their way.
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
  flight.job.answered = answered;
  flight.state = Flight::State::kFree;
  --flying_;
  answers_.try_push(flight.job);
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

CyclicExchange::CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass)
    : channel_(channel), clock_(clock), pass_(std::move(pass)) {}

Result<void> CyclicExchange::exchange(std::span<Request> requests) {
  for (auto& request : requests) request.answered = false;
  if (auto done = cut(requests); !done) return done;
  while (std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return !part.done; })) {
    if (auto done = submit_open(requests); !done) return done;
    if (take_answers(requests)) continue;
    pass_(kPollInterval);
    if (!take_answers(requests)) give_up_late(requests);
  }
  return {};
}

/// Divides the requests into frames: at least one in each, more only if they fit into one cycle.
Result<void> CyclicExchange::cut(std::span<const Request> requests) {
  parts_.clear();
  const auto most = std::min(channel_.bytes_per_cycle(), kLongestFrame);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto size = requests[i].data.size();
    if (size > wire::kMaxDatagramData) {
      return tl::unexpected(
          Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(size), .limit = wire::kMaxDatagramData}});
    }
    bytes += wire::DatagramHeader::kOverhead + size;
    if (parts_.empty() || bytes > most) {
      parts_.push_back({.first = i});
      bytes = wire::kDatagramsOffset + wire::DatagramHeader::kOverhead + size;
    }
    ++parts_.back().count;
  }
  return {};
}

/// Hands over all frames that are not on their way, as many as the channel takes.
Result<void> CyclicExchange::submit_open(std::span<const Request> requests) {
  bool under_way = false;
  for (auto& part : parts_) {
    under_way = under_way || part.id != 0;
    if (part.done || part.id != 0) continue;
    if (part.tries > kRetries) return tl::unexpected(Error{facts::NoAnswer{.tries = kRetries + 1}});
    if (!channel_.submit(make_job(requests.subspan(part.first, part.count), next_id_))) {
      if (under_way) return {};
      return tl::unexpected(Error{facts::ExchangeFull{}});
    }
    part.id = next_id_++;
    ++part.tries;
    part.deadline = clock_.now() + kAnswerTimeout;
    under_way = true;
  }
  return {};
}

AcyclicJob CyclicExchange::make_job(std::span<const Request> requests, std::uint64_t id) {
  AcyclicJob job;
  job.id = id;
  wire::FrameBuilder builder(job.bytes, FrameTag{}.to_mac());
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto& request = requests[i];
    const auto place = builder.add(request.command, static_cast<std::uint8_t>(i), request.address, request.data.size());
    std::copy(request.data.begin(), request.data.end(), builder.data(*place).begin());
  }
  job.size = static_cast<std::uint16_t>(builder.finish().size());
  return job;
}

/// Takes all answers that are there; those to abandoned jobs are skipped. True: something has moved on.
bool CyclicExchange::take_answers(std::span<Request> requests) {
  AcyclicJob job;
  bool any = false;
  while (channel_.take_answer(job)) {
    const auto part = std::find_if(parts_.begin(), parts_.end(), [&](const Part& one) { return one.id == job.id; });
    if (part == parts_.end()) continue;
    any = true;
    part->id = 0;
    part->done = job.answered && match_answers(requests.subspan(part->first, part->count),
                                               std::span<const std::byte>(job.bytes).first(job.size));
    if (!part->done) reopen(static_cast<std::size_t>(part - parts_.begin()), requests);
  }
  return any;
}

void CyclicExchange::give_up_late(std::span<const Request> requests) {
  const auto now = clock_.now();
  // reopen() appends.
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].id == 0 || now < parts_[i].deadline) continue;
    parts_[i].id = 0;
    reopen(i, requests);
  }
}

/// A frame was lost: it is sent again, without what must be sent once only.
void CyclicExchange::reopen(std::size_t part, std::span<const Request> requests) {
  const auto lost = parts_[part];
  const auto own = requests.subspan(lost.first, lost.count);
  if (std::none_of(own.begin(), own.end(), [](const Request& request) { return request.once; })) return;
  parts_[part].done = true;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i].once) continue;
    if (i == 0 || own[i - 1].once) parts_.push_back({.first = lost.first + i, .tries = lost.tries});
    ++parts_.back().count;
  }
}

}  // namespace driveline::ecat_master
