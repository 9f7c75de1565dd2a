#include "gateway/tcp_user.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <array>
#include <charconv>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

namespace driveline::runtime {
namespace {

/// The columns of /proc/net/tcp that are read.
struct TcpRow {
  std::string local;
  std::string remote;
  std::string state;
  std::string user;
};

/// Only an established connection surely belongs to the process that opened it: the kernel lists closed ones as those
/// of user 0.
constexpr std::string_view kEstablished = "01";

/// The kernel prints the address as a number of this machine and the port as it is read. `prefix`: digits before an
/// IPv4 address in the table of IPv6.
std::string tcp_table_text(const sockaddr_in& address, std::string_view prefix) {
  return fmt::format("{}{:08X}:{:04X}", prefix, address.sin_addr.s_addr, ntohs(address.sin_port));
}

TcpRow read_tcp_row(const std::string& line) {
  std::istringstream text(line);
  TcpRow row;
  std::string skipped;
  text >> skipped >> row.local >> row.remote >> row.state;
  for (int i = 0; i < 3; ++i) text >> skipped;  // queues, timer, retransmissions
  text >> row.user;
  return row;
}

std::optional<uid_t> user_number(std::string_view text) {
  uid_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// sockaddr of either end of a connection; none: it is not connected.
template <typename Function>
std::optional<sockaddr_in> tcp_end(int connection, Function function) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (function(connection, reinterpret_cast<sockaddr*>(&address), &size) != 0) return std::nullopt;
  return address;
}

}  // namespace

std::optional<uid_t> find_tcp_user(std::istream& table, const sockaddr_in& client, const sockaddr_in& server) {
  // A client with a socket of IPv6 is listed with a mapped address, ::ffff:127.0.0.1.
  const bool little = htons(1) != 1;
  const std::string mapped = std::string(16, '0') + (little ? "FFFF0000" : "0000FFFF");
  std::string line;
  while (std::getline(table, line)) {
    const auto row = read_tcp_row(line);
    if (row.state != kEstablished) continue;
    for (const std::string_view prefix : {std::string_view{}, std::string_view{mapped}}) {
      if (row.local == tcp_table_text(client, prefix) && row.remote == tcp_table_text(server, prefix)) {
        return user_number(row.user);
      }
    }
  }
  return std::nullopt;
}

std::optional<uid_t> user_of_connection(int connection) {
  const auto client = tcp_end(connection, ::getpeername);
  const auto server = tcp_end(connection, ::getsockname);
  if (!client || !server) return std::nullopt;
  for (const auto* name : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    std::ifstream table(name);
    if (const auto user = find_tcp_user(table, *client, *server)) return user;
  }
  return std::nullopt;
}

}  // namespace driveline::runtime
