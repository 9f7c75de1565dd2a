#include "endpoints/endpoint_host.hpp"

#include <algorithm>
#include <string_view>

namespace driveline::runtime {
namespace {

using slaves::EndpointLink;
using slaves::EndpointMessage;
using slaves::EndpointPacket;
using Transfer = HelperProcess::Transfer;

/// Most messages in one direction before the other direction is served.
constexpr int kBatch = 64;

}  // namespace

Result<void> EndpointHost::start() {
  auto started = HelperProcess::start(program_, {"--socket", std::to_string(HelperProcess::kSocket)});
  if (!started) return tl::unexpected(started.error());
  process_ = std::move(*started);
  sent_address_.reset();
  sent_link_.reset();
  figures_.process = process_.id();
  return {};
}

void EndpointHost::ended(Clock::time_point now) {
  process_.end();
  figures_.running = false;
  figures_.process = 0;
  again_at_ = now + pause_.next();
}

bool EndpointHost::serve(Clock::time_point now) {
  if (!process_.valid()) {
    if (now < again_at_) return false;
    ++figures_.restarts;
    if (const auto started = start(); !started) {
      figures_.failure = describe(started.error());
      ended(now);
      return false;
    }
  }
  bool moved = take_messages(now);
  if (!figures_.running) return moved;
  moved |= tell(now);
  moved |= send_frames();
  return moved;
}

/// Takes messages while the device accepts frames; otherwise they wait in the socket, and then in the end point's
/// stack.
bool EndpointHost::take_messages(Clock::time_point now) {
  for (int i = 0; i < kBatch; ++i) {
    if (!network_.has_room()) return i != 0;
    std::size_t length = 0;
    const auto transfer = process_.receive(packet_.room(), length);
    if (transfer == Transfer::kNotNow) return i != 0;
    if (transfer == Transfer::kEnded) {
      ended(now);
      return true;
    }
    packet_.set_length(length);
    if (!take(packet_)) ++figures_.malformed;
  }
  return true;
}

/// Processes a message of the end point, which is checked like any data from a network.
bool EndpointHost::take(const EndpointPacket& packet) {
  const auto message = packet.message();
  if (!message) return false;
  const auto content = packet.content();
  switch (*message) {
    case EndpointMessage::kReady:
      figures_.running = true;
      pause_.reset();
      return true;
    case EndpointMessage::kFailed:
      figures_.failure.clear();
      for (const auto byte : content) {
        const auto letter = std::to_integer<char>(byte);
        figures_.failure += letter >= ' ' && letter != '\x7f' ? letter : ' ';
      }
      return true;
    case EndpointMessage::kFrame:
      if (content.size() < wire::kMinEoeFrame || content.size() > wire::kMaxEoeFrame) return false;
      frame_.length = content.size();
      std::copy(content.begin(), content.end(), frame_.bytes.begin());
      if (!network_.link_up()) return true;
      network_.offer(frame_);
      ++figures_.to_master;
      return true;
    default:
      return false;
  }
}

template <typename Content>
bool EndpointHost::send(EndpointMessage message, const Content& content) {
  return packet_.write(message, content) && process_.send(packet_.bytes()) == Transfer::kDone;
}

/// Sends address and link before the frames that depend on them.
bool EndpointHost::tell(Clock::time_point now) {
  bool moved = false;
  const auto address = network_.address();
  if (sent_address_ != address && send(EndpointMessage::kAddress, address)) {
    sent_address_ = address;
    moved = true;
  }
  const bool up = network_.link_up();
  if (sent_link_ != up && send(EndpointMessage::kLink, EndpointLink{static_cast<std::uint8_t>(up ? 1 : 0)})) {
    sent_link_ = up;
    moved = true;
  }
  slaves::DeviceStatus status;
  if (network_.next_status(status)) static_cast<void>(send(EndpointMessage::kStatus, status));
  if (now >= next_status_) {
    network_.ask_for_status();
    next_status_ = now + settings_.status_period;
  }
  return moved;
}

bool EndpointHost::send_frames() {
  for (int i = 0; i < kBatch; ++i) {
    if (!network_.next_frame(frame_)) return i != 0;
    ++figures_.from_master;
    const auto bytes = std::span<const std::byte>(frame_.bytes).first(frame_.length);
    if (packet_.write(EndpointMessage::kFrame, bytes) && process_.send(packet_.bytes()) != Transfer::kDone)
      ++figures_.dropped;
  }
  return true;
}

DriveNetworks::Figures EndpointHost::figures() const {
  auto figures = figures_;
  figures.dropped += network_.dropped();
  return figures;
}

}  // namespace driveline::runtime
