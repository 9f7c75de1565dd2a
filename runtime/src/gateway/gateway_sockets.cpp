#include "gateway/gateway_sockets.hpp"

#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "driveline/runtime/eoe/ip_network.hpp"

namespace driveline::runtime {
namespace {

constexpr int kWaitingClients = 8;

sockaddr_in make_address(const wire::IpV4Address& address, std::uint16_t port) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_port = htons(port);
  std::memcpy(&in.sin_addr, address.data(), address.size());
  return in;
}

/// The socket functions take a pointer to the generic address type.
sockaddr* generic(sockaddr_in& address) noexcept {
  return reinterpret_cast<sockaddr*>(&address);
}

rt::FileDescriptor bound_socket(int type, sockaddr_in& address) {
  rt::FileDescriptor socket{::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
  const int yes = 1;
  if (type == SOCK_STREAM) ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (::bind(socket.get(), generic(address), sizeof address) != 0) return {};
  socklen_t size = sizeof address;
  if (::getsockname(socket.get(), generic(address), &size) != 0) return {};
  return socket;
}

}  // namespace

rt::FileDescriptor listen_at(const wire::IpV4Address& address, std::uint16_t& port) {
  auto at = make_address(address, port);
  auto socket = bound_socket(SOCK_STREAM, at);
  if (!socket.valid() || ::listen(socket.get(), kWaitingClients) != 0) return {};
  port = ntohs(at.sin_port);
  return socket;
}

rt::FileDescriptor receive_at(const wire::IpV4Address& address, std::uint16_t& port) {
  auto at = make_address(address, port);
  auto socket = bound_socket(SOCK_DGRAM, at);
  if (socket.valid()) port = ntohs(at.sin_port);
  return socket;
}

Result<GatewaySockets> open_gateway_sockets(const wire::IpV4Address& address, std::uint16_t port) {
  GatewaySockets sockets;
  sockets.port = port;
  sockets.tcp = listen_at(address, sockets.port);
  auto at = make_address(address, sockets.port);
  if (sockets.tcp.valid()) sockets.udp = bound_socket(SOCK_DGRAM, at);
  if (!sockets.udp.valid()) {
    return fail(ErrorKind::kMachine, fmt::format("cannot listen: {}", std::strerror(errno)),
                fmt::format("mailbox gateway at {}:{}", to_text(address), port));
  }
  return sockets;
}

void send_without_delay(int socket) noexcept {
  const int yes = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

std::string to_text(const sockaddr_in& address) {
  wire::IpV4Address ip{};
  std::memcpy(ip.data(), &address.sin_addr, ip.size());
  return fmt::format("{}:{}", to_text(ip), ntohs(address.sin_port));
}

}  // namespace driveline::runtime
