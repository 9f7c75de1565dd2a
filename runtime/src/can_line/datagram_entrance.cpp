#include "can_line/datagram_entrance.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "driveline/runtime/eoe/ip_network.hpp"
#include "gateway/gateway_sockets.hpp"

namespace driveline::runtime {
namespace {

constexpr std::size_t kLongestDatagram = 65536;
/// Packets that are taken at a time, so that the bus goes on.
constexpr int kMostPackets = 64;

bool same_address(const sockaddr_in& one, const sockaddr_in& other) noexcept {
  return one.sin_addr.s_addr == other.sin_addr.s_addr && one.sin_port == other.sin_port;
}

/// The socket functions take a pointer to the generic address type.
sockaddr* any_address(sockaddr_in& address) noexcept {
  return reinterpret_cast<sockaddr*>(&address);
}

}  // namespace

Result<std::unique_ptr<DatagramEntrance>> DatagramEntrance::open(CanLine& line, const wire::IpV4Address& address,
                                                                 std::uint16_t port, std::size_t most_clients) {
  std::unique_ptr<DatagramEntrance> entrance(new DatagramEntrance);
  entrance->socket_ = receive_at(address, port);
  entrance->place_ = fmt::format("cannelloni on UDP at {}:{}", to_text(address), port);
  if (!entrance->socket_.valid()) {
    return fail(ErrorKind::kMachine, fmt::format("cannot listen: {}", std::strerror(errno)), entrance->place_);
  }
  entrance->buffer_.resize(kLongestDatagram);
  for (std::size_t i = 0; i < most_clients; ++i) {
    Client client{std::make_unique<slaves::can::CannelloniUdpDoor>()};
    // Nobody can ask for the recovery from bus off in this protocol.
    line.bus().attach(*client.door, {.bit_rate = line.bit_rate(), .automatic_recovery = true});
    entrance->clients_.push_back(std::move(client));
  }
  return entrance;
}

bool DatagramEntrance::sends() const noexcept {
  return std::any_of(clients_.begin(), clients_.end(), [](const Client& one) { return !one.door->output().empty(); });
}

DatagramEntrance::Client* DatagramEntrance::client_of(const sockaddr_in& address, std::chrono::nanoseconds now) {
  const auto known = std::find_if(clients_.begin(), clients_.end(),
                                  [&](const Client& one) { return one.there && same_address(one.address, address); });
  if (known != clients_.end()) return &*known;
  auto free = std::find_if(clients_.begin(), clients_.end(), [](const Client& one) { return !one.there; });
  if (free == clients_.end()) {
    free = std::min_element(clients_.begin(), clients_.end(),
                            [](const Client& one, const Client& other) { return one.last < other.last; });
    if (now - free->last < kSilence) return nullptr;
  }
  free->address = address;
  free->there = true;
  free->door->open();
  return &*free;
}

void DatagramEntrance::read(std::chrono::nanoseconds now) {
  for (int i = 0; i < kMostPackets; ++i) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto count = ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0, any_address(from), &size);
    if (count < 0) return;
    const std::string_view packet(buffer_.data(), static_cast<std::size_t>(count));
    Client* client = slaves::can::CannelloniUdpDoor::is_packet(packet) ? client_of(from, now) : nullptr;
    if (client == nullptr) {
      ++refused_;
      continue;
    }
    client->last = now;
    client->door->input(packet, now);
  }
}

/// A packet that the socket has no room for waits; one that cannot be sent for another reason is lost, as on a network.
void DatagramEntrance::send_packet(Client& client, bool& full) {
  const auto packet = client.door->output().substr(0, client.door->piece());
  const auto count = ::sendto(socket_.get(), packet.data(), packet.size(), MSG_NOSIGNAL, any_address(client.address),
                              sizeof client.address);
  full = count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
  if (!full) client.door->taken(packet.size());
}

void DatagramEntrance::write() {
  for (Client& client : clients_) {
    for (bool full = false; client.there && !full && !client.door->output().empty();) send_packet(client, full);
  }
}

std::size_t DatagramEntrance::clients() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const Client& one) { return one.there; }));
}

slaves::can::DoorStatistics DatagramEntrance::statistics() const {
  slaves::can::DoorStatistics sum;
  for (const Client& client : clients_) sum += client.door->statistics();
  sum.refused += refused_;
  return sum;
}

}  // namespace driveline::runtime
