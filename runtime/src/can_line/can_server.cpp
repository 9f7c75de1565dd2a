#include "driveline/runtime/can_line/can_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "can_line/datagram_entrance.hpp"
#include "can_line/terminal.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"
#include "driveline/slaves/can/cannelloni_door.hpp"
#include "driveline/slaves/can/slcan_door.hpp"
#include "driveline/slaves/can/socketcand_door.hpp"
#include "gateway/gateway_sockets.hpp"

namespace driveline::runtime {
namespace {

using slaves::can::Door;
using std::chrono::nanoseconds;

/// Bytes that are read from a client at a time.
constexpr std::size_t kPiece = 4096;

timespec to_timespec(nanoseconds time) {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  const auto count = std::max<std::int64_t>(time.count(), 0);
  return {static_cast<time_t>(count / kNsPerSecond), static_cast<long>(count % kNsPerSecond)};
}

nanoseconds since_1970() {
  return std::chrono::system_clock::now().time_since_epoch();
}

}  // namespace

/// A place for a client; without one its door is closed.
struct CanServer::Client {
  std::unique_ptr<Door> door;
  int descriptor = -1;          ///< -1: nobody is there
  rt::FileDescriptor socket{};  ///< owns `descriptor` of a TCP client
  short ready = 0;              ///< events of the last wait
};

/// A listening socket, or a terminal.
struct CanServer::Entrance {
  std::string place;
  rt::FileDescriptor listener{};
  std::optional<Terminal> terminal{};
  std::vector<Client> clients{};
  bool ready = false;  ///< somebody wants to come in
};

CanServer::CanServer(CanLine& line, rt::Clock& clock) : line_(&line), clock_(&clock), start_(clock.now()) {}

CanServer::~CanServer() = default;

void CanServer::add_client(Entrance& entrance, std::unique_ptr<Door> door, bool recovers) {
  // No controller of a client has another bit rate than the line unless the client asks for it.
  line_->bus().attach(*door, {.bit_rate = line_->bit_rate(), .error_frames = true, .automatic_recovery = recovers});
  entrance.clients.push_back({std::move(door), -1, {}, 0});
}

Result<std::unique_ptr<CanServer>> CanServer::open(CanLine& line, const std::string& interface,
                                                   const CanEntrances& entrances, rt::Clock& clock) {
  std::unique_ptr<CanServer> server(new CanServer(line, clock));
  if (auto done = server->listen_everywhere(interface, entrances); !done) return tl::unexpected(done.error());
  for (const auto& link : entrances.ptys) {
    if (auto done = server->open_terminal(link); !done) return tl::unexpected(done.error());
  }
  for (const auto& place : entrances.cannelloni_udp) {
    auto entrance = DatagramEntrance::open(line, place.address, place.port, kMaxClients);
    if (!entrance) return tl::unexpected(entrance.error());
    server->datagrams_.push_back(std::move(*entrance));
  }
  return server;
}

Result<void> CanServer::listen_everywhere(const std::string& interface, const CanEntrances& entrances) {
  const auto listen = [this](const std::vector<TcpPlace>& places, std::string_view protocol, bool recovers,
                             const auto& make_door) -> Result<void> {
    for (TcpPlace place : places) {
      auto entrance = std::make_unique<Entrance>();
      entrance->listener = listen_at(place.address, place.port);
      entrance->place = fmt::format("{} at {}:{}", protocol, to_text(place.address), place.port);
      if (!entrance->listener.valid()) {
        return fail(ErrorKind::kMachine, fmt::format("cannot listen: {}", std::strerror(errno)), entrance->place);
      }
      for (std::size_t i = 0; i < kMaxClients; ++i) add_client(*entrance, make_door(), recovers);
      entrances_.push_back(std::move(entrance));
    }
    return {};
  };
  const auto epoch = since_1970();
  const auto slcan = [] { return std::make_unique<slaves::can::SlcanDoor>(); };
  const auto socketcand = [&] { return std::make_unique<slaves::can::SocketcandDoor>(interface, epoch); };
  const auto tunnel = [] { return std::make_unique<slaves::can::CannelloniTcpDoor>(); };
  if (auto done = listen(entrances.slcan, "slcan", false, slcan); !done) return done;
  if (auto done = listen(entrances.socketcand, "socketcand", false, socketcand); !done) return done;
  return listen(entrances.cannelloni_tcp, "cannelloni on TCP", true, tunnel);
}

Result<void> CanServer::open_terminal(const std::filesystem::path& link) {
  auto terminal = Terminal::open(link);
  if (!terminal) return tl::unexpected(terminal.error());
  auto entrance = std::make_unique<Entrance>();
  entrance->place = fmt::format("slcan at {}", link.string());
  add_client(*entrance, std::make_unique<slaves::can::SlcanDoor>());
  entrance->clients.front().descriptor = terminal->near_end();
  entrance->clients.front().door->open();
  entrance->terminal.emplace(std::move(*terminal));
  entrances_.push_back(std::move(entrance));
  return {};
}

void CanServer::wait(nanoseconds longest) {
  std::vector<pollfd> places;
  for (const auto& entrance : entrances_) {
    if (entrance->listener.valid()) places.push_back({entrance->listener.get(), POLLIN, 0});
    for (const Client& client : entrance->clients) {
      const int in = client.door->room() > 0 ? POLLIN : 0;
      const int out = client.door->output().empty() ? 0 : POLLOUT;
      places.push_back({client.descriptor, static_cast<short>(in | out), 0});
    }
  }
  for (const auto& entrance : datagrams_) {
    places.push_back({entrance->descriptor(), static_cast<short>(POLLIN | (entrance->sends() ? POLLOUT : 0)), 0});
  }
  const auto due = line_->next_event();
  const auto time = to_timespec(due == slaves::can::kNever ? longest : std::min(longest, due - now()));
  if (::ppoll(places.data(), places.size(), &time, nullptr) < 0) {
    for (pollfd& place : places) place.revents = 0;
  }
  auto place = places.begin();
  for (const auto& entrance : entrances_) {
    if (entrance->listener.valid()) entrance->ready = (place++)->revents != 0;
    for (Client& client : entrance->clients) client.ready = (place++)->revents;
  }
}

void CanServer::turn(nanoseconds longest) {
  wait(longest);
  line_->advance(now());
  for (const auto& entrance : entrances_) {
    for (Client& client : entrance->clients) {
      if (client.ready != 0) read(client);
      write(client);
    }
    if (std::exchange(entrance->ready, false)) accept(*entrance);
  }
  for (const auto& entrance : datagrams_) {
    entrance->read(line_->bus().now());
    entrance->write();
  }
}

/// A client that finds all places taken is sent away.
void CanServer::accept(Entrance& entrance) {
  rt::FileDescriptor socket{::accept4(entrance.listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
  if (!socket.valid()) return;
  const auto free = std::find_if(entrance.clients.begin(), entrance.clients.end(),
                                 [](const Client& client) { return client.descriptor < 0; });
  if (free == entrance.clients.end()) return;
  send_without_delay(socket.get());
  free->descriptor = socket.get();
  free->socket = std::move(socket);
  free->door->open();
  write(*free);
}

void CanServer::read(Client& client) {
  std::array<char, kPiece> piece{};
  const auto room = std::min(piece.size(), client.door->room());
  if (client.descriptor < 0) return;
  if (room == 0) {
    if ((client.ready & (POLLERR | POLLHUP)) != 0) drop(client);
    return;
  }
  const auto size = ::read(client.descriptor, piece.data(), room);
  if (size > 0) return client.door->input({piece.data(), static_cast<std::size_t>(size)}, line_->bus().now());
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  drop(client);
}

void CanServer::write(Client& client) {
  if (client.descriptor < 0) return;
  if (const auto output = client.door->output(); !output.empty()) {
    const auto size = client.socket.valid() ? ::send(client.descriptor, output.data(), output.size(), MSG_NOSIGNAL)
                                            : ::write(client.descriptor, output.data(), output.size());
    if (size < 0 && errno != EAGAIN && errno != EINTR) return drop(client);
    if (size > 0) client.door->taken(static_cast<std::size_t>(size));
  }
  if (client.door->closing() && client.door->output().empty()) drop(client);
}

/// A terminal stays: its next client goes on with it.
void CanServer::drop(Client& client) {
  if (!client.socket.valid()) return;
  client.door->leave();
  client.descriptor = -1;
  client.socket = {};
}

std::vector<std::string> CanServer::places() const {
  std::vector<std::string> places;
  for (const auto& entrance : entrances_) places.push_back(entrance->place);
  for (const auto& entrance : datagrams_) places.push_back(entrance->place());
  return places;
}

std::size_t CanServer::clients() const noexcept {
  std::size_t count = 0;
  for (const auto& entrance : entrances_) {
    for (const Client& client : entrance->clients) count += client.descriptor < 0 ? 0U : 1U;
  }
  for (const auto& entrance : datagrams_) count += entrance->clients();
  return count;
}

slaves::can::DoorStatistics CanServer::statistics() const {
  slaves::can::DoorStatistics sum;
  for (const auto& entrance : entrances_) {
    for (const Client& client : entrance->clients) sum += client.door->statistics();
  }
  for (const auto& entrance : datagrams_) sum += entrance->statistics();
  return sum;
}

}  // namespace driveline::runtime
