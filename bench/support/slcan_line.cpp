#include "support/slcan_line.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <stdexcept>
#include <utility>

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame_bits.hpp"
#include "driveline/canopen_wire/slcan.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/can_line/can_server.hpp"
#include "support/realtime.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using rt::FileDescriptor;
using namespace std::chrono_literals;

constexpr double kPatienceNs = 10e9;
/// Frames between the clients at most: more than the queue of a controller has, so that the bus is full, and fewer than
/// those that would wait for seconds in the sockets.
constexpr std::uint64_t kUnderWay = 500;

sockaddr_in local(std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return at;
}

void send_at_once(int socket) {
  const int on = 1;
  static_cast<void>(::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on));
}

/// Lines of a client, from pieces.
class Lines {
 public:
  /// Calls `each` with every line that the bytes complete.
  template <typename Each>
  void add(std::string_view bytes, const Each& each) {
    for (const char c : bytes) {
      if (c == canopen::slcan::kError) throw std::runtime_error("the line has refused a frame");
      if (c != canopen::slcan::kOk) {
        line_ += c;
        continue;
      }
      each(line_);
      line_.clear();
    }
  }

 private:
  std::string line_;
};

constexpr std::uint32_t kNumberedFrame = 0x6F5;  ///< of no device

/// A frame with this number.
canopen::Frame numbered(std::uint64_t number) {
  const auto data = bytes::to_le_bytes(number * 0x9E37'79B9'7F4A'7C15U);  // an odd factor: each number has other bits
  return canopen::Frame::of(kNumberedFrame, data);
}

/// What was received now; empty: nothing.
std::string_view receive_now(int socket, std::array<char, 65536>& buffer) {
  const auto size = ::recv(socket, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (size == 0) throw std::runtime_error("the line has closed a connection");
  return {buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

runtime::CanLineConfig eight_drives() {
  std::string text = "[bus]\ntype = \"can\"\n";
  for (int node = 1; node <= 8; ++node) text += fmt::format("[[slave]]\nname = \"d{0}\"\nnode = {0}\n", node);
  auto config = runtime::parse_can_line_config(text, "line.toml");
  if (!config) throw std::runtime_error(runtime::describe(config.error()));
  return *config;
}

}  // namespace

TcpClient::TcpClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const auto at = local(port);
  if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) {
    throw std::runtime_error("no connection to the line");
  }
  send_at_once(socket_.get());
}

std::string TcpClient::exchange(std::string_view request, std::size_t size) {
  if (::send(get(), request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size())) {
    throw std::runtime_error("a request was not sent");
  }
  std::string answer;
  std::array<char, 256> buffer{};
  while (answer.size() < size) {
    pollfd readable{get(), POLLIN, 0};
    if (::poll(&readable, 1, 5000) <= 0) throw Disturbed("an answer stayed away");
    const auto got = ::recv(get(), buffer.data(), buffer.size(), 0);
    if (got <= 0) throw std::runtime_error("the connection was closed");
    answer.append(buffer.data(), static_cast<std::size_t>(got));
  }
  return answer;
}

TcpEcho::TcpEcho(std::string answer) : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  auto at = local(0);
  socklen_t size = sizeof at;
  if (::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&at), size) != 0 || ::listen(listener_.get(), 1) != 0 ||
      ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&at), &size) != 0) {
    throw std::runtime_error("the echo cannot listen");
  }
  port_ = ntohs(at.sin_port);
  thread_ = std::jthread([this, text = std::move(answer)](const std::stop_token& stop) { run(stop, text); });
}

void TcpEcho::run(const std::stop_token& stop, const std::string& answer) {
  claim_cpu(last_cpu());
  FileDescriptor client;
  std::array<char, 4096> buffer{};
  while (!stop.stop_requested()) {
    pollfd readable{client.valid() ? client.get() : listener_.get(), POLLIN, 0};
    if (::poll(&readable, 1, 50) <= 0) continue;
    if (!client.valid()) {
      client = FileDescriptor{::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC)};
      send_at_once(client.get());
      continue;
    }
    if (::read(client.get(), buffer.data(), buffer.size()) <= 0) {
      client = {};
      continue;
    }
    keep(::send(client.get(), answer.data(), answer.size(), MSG_NOSIGNAL));
  }
}

struct SlcanLine::Parts {
  runtime::CanLineConfig config = eight_drives();
  rt::MonotonicClock clock;
  runtime::CanLine line{config};
  std::unique_ptr<runtime::CanServer> server;
  std::uint16_t port = 0;
  std::jthread thread{};
};

SlcanLine::SlcanLine() : parts_(std::make_unique<Parts>()) {
  runtime::CanEntrances entrances;
  entrances.slcan.emplace_back();
  auto server = runtime::CanServer::open(parts_->line, parts_->config.interface, entrances, parts_->clock);
  if (!server) throw std::runtime_error(runtime::describe(server.error()));
  parts_->server = std::move(*server);
  const std::string place = parts_->server->places().front();
  const auto digits = place.substr(place.rfind(':') + 1);
  std::from_chars(digits.data(), digits.data() + digits.size(), parts_->port);
  parts_->thread = std::jthread([parts = parts_.get()](const std::stop_token& stop) {
    claim_cpu(last_cpu());
    while (!stop.stop_requested()) parts->server->turn(50ms);
  });
}

SlcanLine::~SlcanLine() {
  parts_->thread = {};
}

std::uint16_t SlcanLine::port() const noexcept {
  return parts_->port;
}

FullBus fill_bus(std::uint16_t port, std::chrono::duration<double> duration) {
  TcpClient sender(port);
  TcpClient receiver(port);
  sender.exchange("O\r", 1);
  receiver.exchange("O\r", 1);
  FullBus result;
  std::uint64_t next = 0;
  Lines answers;
  Lines frames;
  const auto take = [&](const std::string& line) {
    const auto parsed = canopen::slcan::parse_line(line);
    if (!parsed || parsed->frame.identifier.value != kNumberedFrame) return;
    while (next < result.sent && numbered(next) != parsed->frame) {
      ++result.lost;
      ++next;
    }
    result.bits += static_cast<double>(canopen::bit_count(parsed->frame));
    ++next;
  };
  std::string waiting;
  std::array<char, 65536> buffer{};
  const double begin = now_ns();
  const double end = begin + duration.count() * 1e9;
  while (now_ns() < end || next < result.sent) {
    if (now_ns() > end + kPatienceNs) break;
    while (now_ns() < end && waiting.size() < 4096 && result.sent < next + kUnderWay)
      waiting += canopen::slcan::line_of(numbered(result.sent++), {}).view();
    std::array<pollfd, 2> ready{pollfd{sender.get(), static_cast<short>(POLLIN | (waiting.empty() ? 0 : POLLOUT)), 0},
                                pollfd{receiver.get(), POLLIN, 0}};
    if (::poll(ready.data(), ready.size(), 100) < 0) throw std::runtime_error("poll");
    answers.add(receive_now(sender.get(), buffer), [](const std::string&) {});
    frames.add(receive_now(receiver.get(), buffer), take);
    if (waiting.empty()) continue;
    const auto size = ::send(sender.get(), waiting.data(), waiting.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (size > 0) waiting.erase(0, static_cast<std::size_t>(size));
  }
  result.seconds = (now_ns() - begin) / 1e9;
  result.lost += result.sent - next;
  return result;
}

}  // namespace driveline::bench
