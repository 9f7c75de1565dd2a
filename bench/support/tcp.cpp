#include "support/tcp.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/ip_icmp.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "driveline/rt/file_descriptor.hpp"
#include "support/retry.hpp"

namespace driveline::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint16_t kEchoPort = 7;
constexpr auto kWindow = std::chrono::milliseconds{100};
constexpr auto kWarmUp = std::chrono::milliseconds{300};

sockaddr_in make_address(const std::string& address, std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  if (::inet_pton(AF_INET, address.c_str(), &at.sin_addr) != 1) throw std::runtime_error(address + " is no address");
  return at;
}

rt::FileDescriptor connect_echo(const std::string& address) {
  const auto at = make_address(address, kEchoPort);
  rt::FileDescriptor socket{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  const timeval patience{1, 0};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) return {};
  return socket;
}

/// Internet checksum (RFC 1071).
std::uint16_t checksum(const std::array<std::uint8_t, 64>& packet) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < packet.size(); i += 2) sum += std::uint32_t{packet[i]} << 8 | packet[i + 1];
  while (sum > 0xFFFF) sum = (sum & 0xFFFF) + (sum >> 16);
  return static_cast<std::uint16_t>(~sum);
}

double us_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

}  // namespace

void await_answer(const std::string& address, std::chrono::nanoseconds patience) {
  const auto deadline = Clock::now() + patience;
  while (!connect_echo(address).valid()) {
    if (Clock::now() > deadline) throw Disturbed(address + " does not answer");
    std::this_thread::sleep_for(std::chrono::milliseconds{50});
  }
}

std::vector<double> ping(const std::string& address, int count) {
  const auto at = make_address(address, 0);
  const rt::FileDescriptor socket{::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_ICMP)};
  if (!socket.valid()) throw std::runtime_error(fmt::format("no ICMP socket: {}", std::strerror(errno)));
  std::vector<double> round_trips;
  for (int i = 0; i < count; ++i) {
    std::array<std::uint8_t, 64> packet{};
    packet[0] = ICMP_ECHO;
    packet[6] = static_cast<std::uint8_t>(i >> 8);
    packet[7] = static_cast<std::uint8_t>(i);
    const auto sum = checksum(packet);
    packet[2] = static_cast<std::uint8_t>(sum >> 8);
    packet[3] = static_cast<std::uint8_t>(sum);
    const auto begin = Clock::now();
    if (::sendto(socket.get(), packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&at), sizeof at) < 0)
      throw std::runtime_error(fmt::format("ping {}: {}", address, std::strerror(errno)));
    for (bool back = false; !back;) {
      pollfd readable{socket.get(), POLLIN, 0};
      if (::poll(&readable, 1, 5000) <= 0) throw Disturbed("a ping to " + address + " stayed away");
      // After the IP header of 20 bytes; other answers and requests arrive here, too.
      std::array<std::uint8_t, 256> answer{};
      const auto size = ::recv(socket.get(), answer.data(), answer.size(), 0);
      back = size >= 28 && answer[20] == ICMP_ECHOREPLY && answer[26] == packet[6] && answer[27] == packet[7];
    }
    round_trips.push_back(us_since(begin));
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
  }
  return round_trips;
}

std::vector<double> echo_load(const std::vector<std::string>& addresses, std::chrono::nanoseconds duration) {
  std::vector<rt::FileDescriptor> sockets;
  std::vector<pollfd> polled;
  for (const auto& address : addresses) {
    sockets.push_back(connect_echo(address));
    if (!sockets.back().valid()) throw Disturbed(address + " takes no connection");
    polled.push_back({sockets.back().get(), POLLIN | POLLOUT, 0});
  }
  const std::vector<std::uint8_t> content(16384, 0x5A);
  std::vector<std::uint8_t> back(65536);
  std::vector<double> ms_per_mib;
  std::size_t bytes = 0;
  const auto begin = Clock::now();
  auto window = begin + kWarmUp;
  while (Clock::now() - begin < duration) {
    if (::poll(polled.data(), polled.size(), 100) < 0) throw std::runtime_error("poll");
    for (const auto& one : polled) {
      if ((one.revents & POLLOUT) != 0)
        static_cast<void>(::send(one.fd, content.data(), content.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
      if ((one.revents & POLLIN) == 0) continue;
      const auto size = ::recv(one.fd, back.data(), back.size(), MSG_DONTWAIT);
      if (size == 0) throw Disturbed("a drive has closed the connection");
      if (size > 0) bytes += static_cast<std::size_t>(size);
    }
    const auto now = Clock::now();
    if (now < window + kWindow) {
      if (now < window) bytes = 0;
      continue;
    }
    const auto ms = std::chrono::duration<double, std::milli>(now - window).count();
    if (bytes > 0) ms_per_mib.push_back(ms * 1048576.0 / static_cast<double>(bytes));
    window = now;
    bytes = 0;
  }
  return ms_per_mib;
}

}  // namespace driveline::bench
