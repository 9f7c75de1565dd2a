#include "driveline/ecat_master/cyclic/cyclic_exchange.hpp"

#include <algorithm>
#include <utility>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/wire/ethernet.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {
namespace {

/// Two more than without a cycle: here the tries follow each other within cycles, and a disturbance may last for
/// several.
constexpr int kTries = 7;
constexpr auto kAnswerTimeout = std::chrono::milliseconds{100};
/// A small part of the shortest cycle: an answer seen before the next cycle allows the next frame to be sent in it.
constexpr auto kPollInterval = std::chrono::microseconds{20};
constexpr std::size_t kLongestFrame = wire::EthernetHeader::kSize + wire::kMaxPayloadBytes;

}  // namespace

bool CyclicExchange::Lot::done() const noexcept {
  return std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.done; });
}

bool CyclicExchange::Lot::handed_over() const noexcept {
  return std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.done || part.id != 0; });
}

CyclicExchange::CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass)
    : channel_(channel), clock_(clock), pass_(std::move(pass)) {}

Result<void> CyclicExchange::exchange(std::span<Request> requests) {
  open_ = {.requests = requests, .tries = kTries};
  if (auto done = cut(open_); !done) return done;
  return carry_out();
}

Result<void> CyclicExchange::relay(const Relay& relay) {
  for (auto& request : relay.begun) request.answered = request.withheld = false;
  begun_ = {};
  if (!relay.begun.empty() && relay.begun.data() == next_.requests.data()) begun_ = std::move(next_);
  const auto round = begun_.round != 0 ? begun_.round : ++rounds_;
  open_ = {.requests = relay.requests, .tries = kTries, .round = round};
  next_ = {.requests = relay.next, .tries = 1, .round = ++rounds_, .behind = round};
  auto done = cut(open_).and_then([&] { return cut(next_); });
  if (done) {
    adopt();
    done = carry_out();
  }
  begun_ = {};
  if (!done) next_ = {};
  return done;
}

/// Answers to the started frames may already be there.
void CyclicExchange::adopt() {
  for (const auto& job : std::exchange(early_, {})) static_cast<void>(take_answer(begun_, job));
  for (auto& part : begun_.parts) part.deadline = clock_.now() + kAnswerTimeout;
}

Result<void> CyclicExchange::carry_out() {
  for (;;) {
    if (auto done = submit(); !done) return done;
    if (begun_.done() && open_.done()) return {};
    if (take_answers()) continue;
    pass_(kPollInterval);
    if (take_answers()) continue;
    give_up_late(begun_);
    give_up_late(open_);
  }
}

/// Divides the requests into frames of at least one request each, and more only if they fit into one cycle.
Result<void> CyclicExchange::cut(Lot& lot) const {
  const auto most = std::min(channel_.bytes_per_cycle(), kLongestFrame);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < lot.requests.size(); ++i) {
    auto& request = lot.requests[i];
    request.answered = request.withheld = false;
    const auto size = request.data.size();
    if (size > wire::kMaxDatagramData) {
      return tl::unexpected(
          Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(size), .limit = wire::kMaxDatagramData}});
    }
    bytes += wire::DatagramHeader::kOverhead + size;
    if (lot.parts.empty() || bytes > most) {
      lot.parts.push_back({.first = i});
      bytes = wire::kDatagramsOffset + wire::DatagramHeader::kOverhead + size;
    }
    ++lot.parts.back().count;
  }
  return {};
}

/// Frames that depend on a round are submitted after all frames of that round.
Result<void> CyclicExchange::submit() {
  for (auto* lot : {&begun_, &open_, &next_}) {
    if (auto done = submit_open(*lot); !done) return done;
    if (!lot->handed_over()) return {};
  }
  return {};
}

/// Submits all frames that are not in flight, as many as the channel takes.
Result<void> CyclicExchange::submit_open(Lot& lot) {
  for (auto& part : lot.parts) {
    if (part.done || part.id != 0) continue;
    if (part.tries >= lot.tries)
      return tl::unexpected(Error{facts::NoAnswer{.tries = static_cast<std::uint32_t>(part.tries)}});
    if (!channel_.submit(make_job(lot, part))) {
      const auto under_way = [](const Lot& any) {
        return std::any_of(any.parts.begin(), any.parts.end(), [](const Part& one) { return one.id != 0; });
      };
      if (under_way(begun_) || under_way(open_) || under_way(next_)) return {};
      return tl::unexpected(Error{facts::ExchangeFull{}});
    }
    part.id = next_id_++;
    ++part.tries;
    part.deadline = clock_.now() + kAnswerTimeout;
  }
  return {};
}

AcyclicJob CyclicExchange::make_job(const Lot& lot, const Part& part) const {
  AcyclicJob job;
  job.id = next_id_;
  job.round = part.tries == 0 ? lot.round : 0;
  job.behind = lot.behind;
  wire::FrameBuilder builder(job.bytes, FrameTag{}.to_mac());
  for (std::size_t i = 0; i < part.count; ++i) {
    const auto& request = lot.requests[part.first + i];
    const auto place = builder.add(request.command, static_cast<std::uint8_t>(i), request.address, request.data.size());
    std::copy(request.data.begin(), request.data.end(), builder.data(*place).begin());
  }
  job.size = static_cast<std::uint16_t>(builder.finish().size());
  return job;
}

/// Takes all available answers; those to abandoned jobs are skipped. Returns whether there was progress.
bool CyclicExchange::take_answers() {
  AcyclicJob job;
  bool any = false;
  while (channel_.take_answer(job)) {
    const bool early =
        std::any_of(next_.parts.begin(), next_.parts.end(), [&](const Part& one) { return one.id == job.id; });
    if (early) early_.push_back(job);
    any = take_answer(begun_, job) || take_answer(open_, job) || any;
  }
  return any;
}

/// Returns false if it is not the answer to a frame of this lot.
bool CyclicExchange::take_answer(Lot& lot, const AcyclicJob& job) {
  const auto part = std::find_if(lot.parts.begin(), lot.parts.end(), [&](const Part& one) { return one.id == job.id; });
  if (part == lot.parts.end()) return false;
  part->id = 0;
  const auto own = lot.requests.subspan(part->first, part->count);
  for (auto& request : own) request.withheld = job.withheld;
  part->done =
      job.withheld || (job.answered && match_answers(own, std::span<const std::byte>(job.bytes).first(job.size)));
  if (!part->done) reopen(lot, static_cast<std::size_t>(part - lot.parts.begin()));
  return true;
}

void CyclicExchange::give_up_late(Lot& lot) {
  const auto now = clock_.now();
  // By index, because reopen() appends to the vector.
  for (std::size_t i = 0; i < lot.parts.size(); ++i) {
    if (lot.parts[i].id == 0 || now < lot.parts[i].deadline) continue;
    lot.parts[i].id = 0;
    reopen(lot, i);
  }
}

/// Schedules a lost frame again, without requests that must be sent only once.
void CyclicExchange::reopen(Lot& lot, std::size_t part) {
  if (lot.behind != 0) {
    lot.parts[part].done = true;
    return;
  }
  const auto lost = lot.parts[part];
  const auto own = lot.requests.subspan(lost.first, lost.count);
  if (std::none_of(own.begin(), own.end(), [](const Request& request) { return request.once; })) return;
  lot.parts[part].done = true;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i].once) continue;
    if (i == 0 || own[i - 1].once) lot.parts.push_back({.first = lost.first + i, .tries = lost.tries});
    ++lot.parts.back().count;
  }
}

}  // namespace driveline::ecat_master
