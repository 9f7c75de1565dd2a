#include "driveline/canopen_client/scan.hpp"

#include <algorithm>
#include <numeric>

#include "driveline/canopen_wire/sdo.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint16_t kDeviceType = 0x1000;
/// Most bits of a frame of eight bytes: 47 + 64 and (33 + 64) / 4 stuff bits.
constexpr std::int64_t kFrameBits = 47 + 64 + 24;
/// Requests and answers take one of so many parts of the bus.
constexpr std::int64_t kShare = 10;
constexpr nanoseconds kScanPatience = std::chrono::seconds{1};  ///< with a full queue of the adapter

/// Most time of a request and its answer on the bus.
nanoseconds exchange_time(std::uint32_t bit_rate) noexcept {
  return nanoseconds{std::chrono::nanoseconds{std::chrono::seconds{1}}.count() * 2 * kFrameBits /
                     std::max(bit_rate, 1U)};
}

}  // namespace

Scan::Scan(BusLink& link, ScanOptions options) : link_(&link), options_(std::move(options)) {
  if (!options_.nodes.empty()) return;
  options_.nodes.resize(kMaxNodeId);
  std::iota(options_.nodes.begin(), options_.nodes.end(), std::uint8_t{1});
}

nanoseconds Scan::pace(std::uint32_t bit_rate) noexcept {
  return exchange_time(bit_rate) * kShare;
}

ClientResult<std::vector<FoundNode>> Scan::run(const Progress& progress) {
  std::size_t done = 0;
  for (const auto node : options_.nodes) {
    if (progress) progress(done, options_.nodes.size());
    if (const auto asked = ask(node); !asked) return tl::unexpected(asked.error());
    ++done;
  }
  return found();
}

ClientResult<void> Scan::ask(std::uint8_t node) {
  const SdoMessage request{sdo_command(SdoRequest::kInitiateUpload), kDeviceType, 0, {}};
  const auto sent = link_->send(Frame::of(predefined::kSdoClientToServer + node, request.encode()), kScanPatience);
  if (!sent) return sent;
  const nanoseconds begin = link_->now();
  // Frames of the other nodes go before the answer on a busy bus: the share of a scan is what it may wait for.
  listen_until(begin + options_.answer_timeout + pace(options_.bit_rate), node);
  listen_until(begin + pace(options_.bit_rate), 0);
  if (link_->stopped()) return tl::unexpected(ClientError{ClientErrorKind::kStopped});
  if (link_->down()) return tl::unexpected(ClientError{ClientErrorKind::kDown});
  return {};
}

void Scan::listen_until(nanoseconds deadline, std::uint8_t awaited) {
  while (awaited == 0 || !answers_[awaited]) {
    const auto received = link_->receive(deadline);
    if (!received) return;
    take(*received);
    if (link_->now() >= deadline) return;
  }
}

void Scan::take(const ReceivedFrame& received) {
  states_.receive(received);
  const auto& [identifier, kind, length, data] = received.frame;
  constexpr std::uint32_t kBase = predefined::kSdoServerToClient;
  const bool is_answer = kind == FrameKind::kData && !identifier.extended && identifier.value > kBase &&
                         identifier.value <= kBase + kMaxNodeId;
  if (!is_answer) return;
  const auto message = SdoMessage::decode(received.frame.payload());
  if (!message || message->index != kDeviceType || message->subindex != 0) return;
  const std::size_t node = identifier.value - kBase;
  answers_[node] = true;
  if (message->specifier() == static_cast<std::uint8_t>(SdoResponse::kInitiateUpload) && message->expedited()) {
    device_types_[node] = message->number();
  }
}

std::vector<FoundNode> Scan::found() const {
  std::vector<FoundNode> nodes;
  for (std::uint8_t node = 1; node <= kMaxNodeId; ++node) {
    const auto& condition = states_.of(node);
    if (!answers_[node] && !condition.state && condition.emergencies == 0) continue;
    nodes.push_back({node, answers_[node], device_types_[node], condition.state});
  }
  return nodes;
}

}  // namespace driveline::canopen
