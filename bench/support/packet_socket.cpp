#include "support/packet_socket.hpp"

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <stdexcept>

#include "driveline/port/raw_socket_port.hpp"

namespace driveline::bench {

PacketSocket::PacketSocket(Look look)
    : socket_(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | (look == Look::kReturnsAtOnce ? SOCK_NONBLOCK : 0), 0)) {
  if (!socket_.valid()) throw std::runtime_error("no packet socket");
  const int on = 1;
  const int priority = port::RawSocketConfig{}.priority;
  const timeval patience{0, 50'000};
  setsockopt(socket_.get(), SOL_SOCKET, SO_PRIORITY, &priority, sizeof priority);
  setsockopt(socket_.get(), SOL_PACKET, PACKET_QDISC_BYPASS, &on, sizeof on);
  setsockopt(socket_.get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on);
  setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}

void PacketSocket::bind_to(const std::string& interface) const {
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(wire::kEtherTypeEtherCat);
  address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot bind to " + interface);
  }
}

}  // namespace driveline::bench
