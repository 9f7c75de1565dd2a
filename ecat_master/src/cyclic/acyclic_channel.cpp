#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"

#include <algorithm>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::size_t kRingFrames = 4;
constexpr int kRetries = 4;
constexpr auto kAnswerTimeout = std::chrono::milliseconds{100};
constexpr auto kPollInterval = std::chrono::microseconds{125};

}  // namespace

AcyclicChannel::AcyclicChannel(std::uint32_t lost_after_cycles, std::size_t bytes_per_cycle)
    : requests_(kRingFrames),
      answers_(kRingFrames),
      lost_after_cycles_(lost_after_cycles),
      bytes_per_cycle_(std::clamp(bytes_per_cycle, wire::kMinFrameBytes, port::kMaxFrameBytes)) {}

void AcyclicChannel::send_next(port::Port& port, FrameTag tag) noexcept {
  credit_ = std::min(credit_ + bytes_per_cycle_, port::kMaxFrameBytes);
  if (in_flight_) return;
  if (!waiting_) waiting_ = requests_.try_pop(flying_);
  if (!waiting_ || flying_.size > credit_) return;
  waiting_ = false;
  credit_ -= flying_.size;
  const auto mac = tag.to_mac();
  std::copy(mac.begin(), mac.end(), flying_.bytes.begin() + 6);
  tag_ = tag;
  age_ = 0;
  // A frame that could not be sent is treated as lost.
  in_flight_ = true;
  static_cast<void>(port.send(std::span(flying_.bytes).first(flying_.size)));
}

bool AcyclicChannel::accept(std::span<const std::byte> frame, FrameTag tag) noexcept {
  if (!in_flight_ || tag != tag_ || frame.size() < flying_.size) return false;
  std::copy_n(frame.begin(), flying_.size, flying_.bytes.begin());
  flying_.answered = true;
  in_flight_ = false;
  answers_.try_push(flying_);
  return true;
}

void AcyclicChannel::end_cycle() noexcept {
  if (!in_flight_ || ++age_ < lost_after_cycles_) return;
  flying_.answered = false;
  in_flight_ = false;
  answers_.try_push(flying_);
}

CyclicExchange::CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass)
    : channel_(channel), clock_(clock), pass_(std::move(pass)) {}

Result<void> CyclicExchange::exchange(std::span<Request> requests) {
  for (auto& request : requests) request.answered = false;
  while (!requests.empty()) {
    auto taken = exchange_frame(requests);
    if (!taken) return tl::unexpected(taken.error());
    requests = requests.subspan(*taken);
  }
  return {};
}

/// Sends as many of the first requests as fit into a frame and returns their number.
Result<std::size_t> CyclicExchange::exchange_frame(std::span<Request> requests) {
  AcyclicJob job;
  wire::FrameBuilder builder(job.bytes, FrameTag{}.to_mac());
  std::size_t count = 0;
  std::size_t bytes = wire::kDatagramsOffset;
  for (; count < requests.size(); ++count) {
    const auto& request = requests[count];
    // At least one request is sent; more only if they fit into one cycle.
    bytes += wire::DatagramHeader::kOverhead + request.data.size();
    if (count > 0 && bytes > channel_.bytes_per_cycle()) break;
    const auto place =
        builder.add(request.command, static_cast<std::uint8_t>(count), request.address, request.data.size());
    if (!place) break;
    std::copy(request.data.begin(), request.data.end(), builder.data(*place).begin());
  }
  if (count == 0) {
    return tl::unexpected(Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(requests[0].data.size()),
                                                       .limit = wire::kMaxDatagramData}});
  }
  job.size = static_cast<std::uint16_t>(builder.finish().size());
  for (int attempt = 0; attempt <= kRetries; ++attempt) {
    AcyclicJob answer = job;
    answer.id = next_id_++;
    if (!channel_.submit(answer)) return tl::unexpected(Error{facts::ExchangeFull{}});
    if (await(answer.id, answer) &&
        match_answers(requests.first(count), std::span<const std::byte>(answer.bytes).first(answer.size))) {
      return count;
    }
  }
  return tl::unexpected(Error{facts::NoAnswer{.tries = kRetries + 1}});
}

/// Waits for the result of job `id`; answers to abandoned jobs are skipped.
bool CyclicExchange::await(std::uint64_t id, AcyclicJob& job) {
  const auto deadline = clock_.now() + kAnswerTimeout;
  for (;;) {
    while (channel_.take_answer(job)) {
      if (job.id == id) return job.answered;
    }
    if (clock_.now() >= deadline) return false;
    pass_(kPollInterval);
  }
}

}  // namespace driveline::ecat_master
