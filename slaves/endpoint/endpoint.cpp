#include "endpoint.hpp"

#include <sys/socket.h>

#include <cstdio>
#include <vector>

#include "network_namespace.hpp"

namespace driveline::endpoint {
namespace {

using slaves::EndpointAddress;
using slaves::EndpointLink;
using slaves::EndpointMessage;
using slaves::EndpointPacket;

constexpr int kIdleMilliseconds = 1000;
/// Maximum number of frames in one direction before the other direction is served.
constexpr int kBatch = 64;

}  // namespace

Outcome<void> Endpoint::run() {
  auto result = set_up().and_then([this] {
    tell(EndpointMessage::kReady);
    return pump();
  });
  if (!result) tell(EndpointMessage::kFailed, describe(result.error()));
  return result;
}

Outcome<void> Endpoint::set_up() {
  int type = 0;
  socklen_t size = sizeof type;
  if (::getsockopt(socket_.get(), SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_SEQPACKET) {
    return tl::unexpected(Failure{"the descriptor is not a SOCK_SEQPACKET socket"});
  }
  if (auto entered = enter_own_network(); !entered) return entered;
  auto wire = VirtualWire::open();
  if (!wire) return tl::unexpected(wire.error());
  wire_.emplace(std::move(*wire));
  auto echo = EchoServer::open();
  if (!echo) return tl::unexpected(echo.error());
  echo_.emplace(std::move(*echo));
  auto web = WebServer::open(state_);
  if (!web) return tl::unexpected(web.error());
  web_.emplace(std::move(*web));
  return drop_privileges();
}

Outcome<void> Endpoint::pump() {
  std::vector<pollfd> descriptors;
  for (;;) {
    descriptors.clear();
    descriptors.push_back({socket_.get(), POLLIN, 0});
    descriptors.push_back({wire_->descriptor(), POLLIN, 0});
    echo_->wait_for(descriptors);
    web_->wait_for(descriptors);
    if (::poll(descriptors.data(), descriptors.size(), kIdleMilliseconds) < 0 && errno != EINTR) return failed("poll");
    state_.running = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - start_);
    if (!take_messages()) return {};
    echo_->serve();
    web_->serve();
    forward_frames();
  }
}

bool Endpoint::take_messages() {
  for (int i = 0; i < kBatch; ++i) {
    const auto room = packet_.room();
    const auto length = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (length == 0) return false;
    if (length < 0) return errno == EAGAIN || errno == EINTR;
    packet_.set_length(static_cast<std::size_t>(length));
    take(packet_);
  }
  return true;
}

void Endpoint::take(const EndpointPacket& packet) {
  const auto message = packet.message();
  if (!message) return;
  switch (*message) {
    case EndpointMessage::kFrame:
      if (!state_.link) return;
      ++state_.frames_in;
      wire_->send(packet.content());
      return;
    case EndpointMessage::kAddress:
      if (const auto address = packet.content_as<EndpointAddress>()) {
        state_.address = *address;
        const auto set = wire_->set_address(*address);
        if (!set) std::fprintf(stderr, "driveline-endpoint: %s\n", describe(set.error()).c_str());
      }
      return;
    case EndpointMessage::kLink:
      if (const auto link = packet.content_as<EndpointLink>()) state_.link = link->up != 0;
      return;
    case EndpointMessage::kStatus:
      if (const auto status = packet.content_as<slaves::DeviceStatus>()) state_.device = *status;
      return;
    default:
      return;
  }
}

/// A frame that the simulation cannot accept is lost, as in any network.
void Endpoint::forward_frames() {
  EndpointPacket packet;
  for (int i = 0; i < kBatch; ++i) {
    const auto length = wire_->receive(frame_);
    if (length == 0) return;
    if (!state_.link || !packet.write(EndpointMessage::kFrame, std::span(frame_).first(length))) continue;
    const auto bytes = packet.bytes();
    if (::send(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0) ++state_.frames_out;
  }
}

void Endpoint::tell(EndpointMessage message, std::string_view text) {
  EndpointPacket packet;
  if (!packet.write(message, std::as_bytes(std::span(text.data(), text.size())))) return;
  const auto bytes = packet.bytes();
  static_cast<void>(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL));
}

}  // namespace driveline::endpoint
