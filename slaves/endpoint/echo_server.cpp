#include "echo_server.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace driveline::endpoint {
namespace {

constexpr std::size_t kBuffer = 16384;
constexpr int kBacklog = 16;

}  // namespace

Outcome<EchoServer> EchoServer::open() {
  rt::FileDescriptor listener{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kPort);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the sockets API requires it
  if (::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener.get(), kBacklog) != 0) {
    return failed("TCP port 7 cannot be opened");
  }
  return EchoServer(std::move(listener));
}

void EchoServer::wait_for(std::vector<pollfd>& descriptors) const {
  if (connections_.size() < kMaxConnections) descriptors.push_back({listener_.get(), POLLIN, 0});
  for (const auto& connection : connections_) {
    const short events = connection.waiting.empty() ? POLLIN : POLLOUT;
    descriptors.push_back({connection.socket.get(), events, 0});
  }
}

void EchoServer::serve() {
  while (connections_.size() < kMaxConnections) {
    rt::FileDescriptor socket{::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)};
    if (!socket.valid()) break;
    connections_.push_back({std::move(socket), {}});
  }
  std::erase_if(connections_, [](Connection& connection) { return !serve(connection); });
}

bool EchoServer::serve(Connection& connection) {
  if (connection.waiting.empty()) {
    connection.waiting.resize(kBuffer);
    const auto length = ::recv(connection.socket.get(), connection.waiting.data(), kBuffer, 0);
    const bool nothing_yet = length < 0 && (errno == EAGAIN || errno == EINTR);
    connection.waiting.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
    if (length <= 0) return nothing_yet;
  }
  const auto sent = ::send(connection.socket.get(), connection.waiting.data(), connection.waiting.size(), MSG_NOSIGNAL);
  if (sent < 0) return errno == EAGAIN || errno == EINTR;
  connection.waiting.erase(connection.waiting.begin(), connection.waiting.begin() + sent);
  return true;
}

}  // namespace driveline::endpoint
