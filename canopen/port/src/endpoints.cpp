#include "endpoints.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "driveline/canopen_wire/text.hpp"
#include "driveline/rt/time_conversion.hpp"

namespace driveline::canopen {
namespace {

const sockaddr* sockaddr_of(const sockaddr_in& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);
}

/// The result of a connection that is under way: errno, 0 for success.
int await_connection(int socket, std::chrono::nanoseconds patience) noexcept {
  pollfd request{socket, POLLOUT, 0};
  const timespec timeout = rt::to_timespec(patience);
  int ready = -1;
  do {
    ready = ::ppoll(&request, 1, &timeout, nullptr);
  } while (ready < 0 && errno == EINTR);
  if (ready == 0) return ETIMEDOUT;
  int error_number = 0;
  socklen_t size = sizeof error_number;
  return ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error_number, &size) == 0 ? error_number : errno;
}

}  // namespace

CanPortError system_error(std::string_view what, std::string_view place, int error_number) {
  return {CanPortErrorCode::kMachine, "cannot " + std::string(what) + " " + std::string(place) + ": " +
                                          std::generic_category().message(error_number) + "."};
}

tl::expected<sockaddr_in, CanPortError> parse_address(std::string_view text) {
  const auto colon = text.find(':');
  const std::string host(text.substr(0, colon));
  const auto port = decimal_number(colon == std::string_view::npos ? std::string_view() : text.substr(colon + 1));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const bool known = host == "localhost" || ::inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1;
  if (!known || !port || *port == 0 || *port > 0xFFFF) {
    return tl::unexpected(CanPortError{CanPortErrorCode::kUsage, "'" + std::string(text) +
                                                                     "' is no HOST:PORT; HOST is an IPv4 address or "
                                                                     "localhost, PORT is 1 to 65535."});
  }
  if (host == "localhost") address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(*port));
  return address;
}

tl::expected<rt::FileDescriptor, CanPortError> connect_tcp(std::string_view address,
                                                           std::chrono::nanoseconds patience) {
  const auto to = parse_address(address);
  if (!to) return tl::unexpected(to.error());
  rt::FileDescriptor socket{::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) return tl::unexpected(system_error("make a socket for", address, errno));
  int error_number = ::connect(socket.get(), sockaddr_of(*to), sizeof *to) == 0 ? 0 : errno;
  if (error_number == EINPROGRESS || error_number == EINTR) error_number = await_connection(socket.get(), patience);
  if (error_number != 0) return tl::unexpected(system_error("connect to", address, error_number));
  const int on = 1;
  ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return socket;
}

tl::expected<rt::FileDescriptor, CanPortError> connect_udp(std::string_view address, std::uint16_t local) {
  const auto to = parse_address(address);
  if (!to) return tl::unexpected(to.error());
  rt::FileDescriptor socket{::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) return tl::unexpected(system_error("make a socket for", address, errno));
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_ANY);
  here.sin_port = htons(local);
  if (::bind(socket.get(), sockaddr_of(here), sizeof here) != 0)
    return tl::unexpected(system_error("use the local UDP port", std::to_string(local), errno));
  if (::connect(socket.get(), sockaddr_of(*to), sizeof *to) != 0)
    return tl::unexpected(system_error("send to", address, errno));
  return socket;
}

tl::expected<rt::FileDescriptor, CanPortError> open_terminal(const std::filesystem::path& path) {
  const auto fail = [&](std::string_view what) { return tl::unexpected(system_error(what, path.string(), errno)); };
  rt::FileDescriptor terminal{::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (!terminal.valid()) return fail("open");
  termios settings{};
  if (::tcgetattr(terminal.get(), &settings) != 0) return fail("use as a terminal");
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  ::cfsetspeed(&settings, B115200);
  if (::tcsetattr(terminal.get(), TCSANOW, &settings) != 0) return fail("set up the terminal");
  ::tcflush(terminal.get(), TCIFLUSH);
  return terminal;
}

}  // namespace driveline::canopen
