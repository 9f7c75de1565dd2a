#include "commands/command_input.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <thread>

#include "console.hpp"

namespace driveline::cli {

namespace {

/// Large enough for a piece of a path with many moves, bytes.
constexpr std::size_t kLongestCommand = std::size_t{64} << 10;
constexpr std::string_view kNoDescriptor = "error: no file descriptor is left for another client (ulimit -n)\n";
/// Pause of the loop that polls the sockets when a client can neither be accepted nor turned away.
constexpr std::chrono::milliseconds kDescriptorPause{10};

tl::expected<sockaddr_un, Failure> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return misused(fmt::format("{}: the path of a socket has 1 to {} characters", path, sizeof address.sun_path - 1));
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

/// Socket functions take a pointer to the generic address type.
const sockaddr* generic(const sockaddr_un& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);
}

rt::FileDescriptor make_socket(int flags = 0) {
  return rt::FileDescriptor{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0)};
}

/// Repeats a system call until no signal interrupts it. Calls on a socket with a time limit are interrupted even by
/// signals whose handlers restart system calls (signal(7)).
template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

bool connect_to(const rt::FileDescriptor& socket, const sockaddr_un& address) {
  return socket.valid() &&
         uninterrupted([&] { return ::connect(socket.get(), generic(address), sizeof address); }) == 0;
}

/// Number of bytes received into `room`; 0: the other end has closed; negative: an error.
ssize_t receive_some(int socket, std::span<char> room) {
  return uninterrupted([&] { return ::recv(socket, room.data(), room.size(), 0); });
}

bool write_all(int socket, std::string_view text) {
  while (!text.empty()) {
    const auto count = uninterrupted([&] { return ::send(socket, text.data(), text.size(), MSG_NOSIGNAL); });
    if (count < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

/// Sets a time limit for every operation on the socket.
void limit_waiting(int socket, std::chrono::milliseconds timeout) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  const timeval limit{seconds.count(), std::chrono::microseconds(timeout - seconds).count()};
  for (const int direction : {SO_RCVTIMEO, SO_SNDTIMEO}) {
    ::setsockopt(socket, SOL_SOCKET, direction, &limit, sizeof limit);
  }
}

bool timed_out() {
  return errno == EAGAIN || errno == EWOULDBLOCK;
}

/// Sends a command. Returns whether there may be an answer: also when the other end has closed the connection without
/// waiting for the command, because it has then said why.
bool send_line(int socket, std::string_view command) {
  return write_all(socket, fmt::format("{}\n", command)) || errno == EPIPE || errno == ECONNRESET;
}

/// Credentials of the process at the other end of a local socket.
std::optional<ucred> peer_of(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  return peer;
}

/// The error for a listener that does not answer, with its process ID if the system provides it.
tl::unexpected<Failure> silent(const std::string& path, std::string_view listener, int socket,
                               std::chrono::milliseconds timeout) {
  const auto peer = peer_of(socket);
  return failed(fmt::format(
      "{}: no answer within {} ms; the {} that listens there{} is stopped or has not started to work yet", path,
      timeout.count(), listener, peer && peer->pid > 0 ? fmt::format(" (process {})", peer->pid) : ""));
}

/// The error for a failed attempt to connect; call it right after the attempt, while errno is valid.
tl::unexpected<Failure> unreachable(const std::string& path, std::string_view listener,
                                    const rt::FileDescriptor& socket, std::chrono::milliseconds timeout) {
  if (socket.valid() && timed_out()) return silent(path, listener, socket.get(), timeout);
  return failed(fmt::format("{}: cannot be reached: {}; driveline {} --control {} listens there", path,
                            std::strerror(errno), listener, path));
}

/// Reading from the terminal in the background would stop the program.
bool may_read_stdin() {
  return isatty(STDIN_FILENO) == 0 || tcgetpgrp(STDIN_FILENO) == getpgrp();
}

}  // namespace

Outcome<std::unique_ptr<CommandInput>> CommandInput::open(const std::string& path, Sources sources) {
  std::unique_ptr<CommandInput> input(new CommandInput(path));
  input->stdin_open_ = sources == Sources::kSocketAndStdin;
  if (path.empty()) return input;
  const auto address = address_of(path);
  if (!address) return tl::unexpected(address.error());
  struct stat found = {};
  if (::lstat(path.c_str(), &found) == 0) {
    if (!S_ISSOCK(found.st_mode) || listener_at(path)) {
      input->path_.clear();
      return failed(fmt::format("{}: already exists; give another name", path));
    }
    ::unlink(path.c_str());
  }
  input->listener_ = make_socket(SOCK_NONBLOCK);
  const int socket = input->listener_.get();
  // Only the owner of the socket may send commands.
  const auto mask = ::umask(0177);
  const bool bound = socket >= 0 && ::bind(socket, generic(*address), sizeof *address) == 0;
  const int error = errno;
  ::umask(mask);
  if (!bound || ::listen(socket, 8) != 0) {
    if (!bound) input->path_.clear();
    return failed(fmt::format("{}: cannot listen: {}", path, std::strerror(bound ? errno : error)));
  }
  return input;
}

CommandInput::~CommandInput() {
  if (listener_.valid()) ::unlink(path_.c_str());
}

void CommandInput::run(std::chrono::milliseconds timeout, CommandExecutor& executor) {
  // poll() ignores negative descriptors.
  std::vector<pollfd> requests{pollfd{stdin_open_ && may_read_stdin() ? STDIN_FILENO : -1, POLLIN, 0},
                               pollfd{listener_.get(), POLLIN, 0}};
  for (const auto& client : clients_) {
    const auto events = static_cast<short>(client.answered ? POLLOUT : POLLIN);
    requests.push_back({client.waits ? -1 : client.socket.get(), events, 0});
  }
  if (::poll(requests.data(), requests.size(), static_cast<int>(timeout.count())) <= 0) return;
  if (requests[0].revents != 0) read_stdin(executor);
  if (requests[1].revents != 0) accept_clients(executor);
  serve_clients(executor);
}

void CommandInput::supply(std::uint64_t connection, std::string_view text, CommandExecutor& executor) {
  for (auto& client : clients_) {
    if (client.sender.connection != connection || !client.waits) continue;
    client.answer = fmt::format("{}\n", text);
    client.waits = false;
    client.answered = true;
    send_answer(client);
    if (client.disconnected && client.stays) executor.disconnected(client.sender);
  }
  std::erase_if(clients_, [](const Client& client) { return client.disconnected; });
}

void CommandInput::read_stdin(CommandExecutor& executor) {
  std::array<char, 512> buffer;
  const auto count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
  if (count <= 0) {
    stdin_open_ = count < 0 && errno == EINTR;
    return;
  }
  typed_.append(buffer.data(), static_cast<std::size_t>(count));
  for (auto end = typed_.find('\n'); end != std::string::npos; end = typed_.find('\n')) {
    const auto reply = executor.execute({}, std::string_view(typed_).substr(0, end));
    if (!reply.text.empty()) print_line(reply.text);
    typed_.erase(0, end + 1);
  }
  if (typed_.size() > kLongestCommand) typed_.clear();
}

/// Drops the oldest client that has not sent a repeatable command: other clients may be moving axes.
bool CommandInput::make_room() {
  if (clients_.size() < kMaxClients) return true;
  const auto oldest = std::find_if(clients_.begin(), clients_.end(), [](const Client& one) { return !one.stays; });
  if (oldest == clients_.end()) return false;
  clients_.erase(oldest);
  return true;
}

void CommandInput::accept_clients(CommandExecutor& executor) {
  for (;;) {
    rt::FileDescriptor socket{::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)};
    if (!socket.valid()) {
      if (!reserve_.turn_away(listener_.get(), kNoDescriptor)) std::this_thread::sleep_for(kDescriptorPause);
      return;
    }
    const auto peer = peer_of(socket.get());
    if (!peer || (peer->uid != 0 && peer->uid != ::geteuid())) {
      static_cast<void>(write_all(socket.get(), "error: the line belongs to another user\n"));
      if (peer) executor.refused({0, peer->pid, peer->uid});
      continue;
    }
    if (!make_room()) {
      static_cast<void>(write_all(socket.get(), "error: too many clients\n"));
      continue;
    }
    Client client;
    client.socket = std::move(socket);
    client.sender = {++connections_, peer->pid, peer->uid};
    clients_.push_back(std::move(client));
  }
}

void CommandInput::serve_clients(CommandExecutor& executor) {
  for (auto& client : clients_) {
    do {
      if (!client.answered && !client.waits) receive(client, executor);
      if (client.answered) send_answer(client);
      // A further command may have arrived with the previous one.
    } while (!client.disconnected && !client.answered && !client.waits &&
             client.received.find('\n') != std::string::npos);
    if (client.disconnected && client.stays) executor.disconnected(client.sender);
  }
  std::erase_if(clients_, [](const Client& client) { return client.disconnected; });
}

/// Reads a part of the command; executes it when it is complete, at the end of the line or of the stream.
void CommandInput::receive(Client& client, CommandExecutor& executor) {
  std::array<char, 512> buffer;
  while (client.received.find('\n') == std::string::npos && client.received.size() < kLongestCommand) {
    const auto count = ::recv(client.socket.get(), buffer.data(), buffer.size(), 0);
    if (count < 0) {
      client.disconnected = errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR;
      return;
    }
    if (count == 0 && client.received.empty()) {
      client.disconnected = true;
      return;
    }
    if (count == 0) break;
    client.received.append(buffer.data(), static_cast<std::size_t>(count));
  }
  const auto end = client.received.find('\n');
  auto reply = executor.execute(client.sender, std::string_view(client.received).substr(0, end));
  client.received.erase(0, end == std::string::npos ? end : end + 1);
  client.answer = std::move(reply.text) + "\n";
  client.stays = client.stays || reply.stays;
  client.waits = reply.later;
  client.answered = !reply.later;
}

void CommandInput::send_answer(Client& client) {
  while (!client.answer.empty()) {
    const auto count = ::send(client.socket.get(), client.answer.data(), client.answer.size(), MSG_NOSIGNAL);
    if (count < 0) {
      client.disconnected = errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR;
      return;
    }
    client.answer.erase(0, static_cast<std::size_t>(count));
  }
  client.answered = false;
  client.disconnected = !client.stays;
}

std::optional<pid_t> listener_at(const std::string& path) {
  const auto address = address_of(path);
  const auto socket = make_socket();
  if (!address || !socket.valid()) return std::nullopt;
  limit_waiting(socket.get(), kAnswerTimeout);
  if (!connect_to(socket, *address)) return std::nullopt;
  const auto peer = peer_of(socket.get());
  return peer ? std::optional(peer->pid) : std::nullopt;
}

Outcome<CommandConnection> CommandConnection::open(const std::string& path, std::string_view listener) {
  const auto address = address_of(path);
  if (!address) return tl::unexpected(address.error());
  auto socket = make_socket();
  if (socket.valid()) limit_waiting(socket.get(), kAnswerTimeout);
  if (!connect_to(socket, *address)) {
    return unreachable(path, listener, socket, kAnswerTimeout);
  }
  return CommandConnection(path, listener, std::move(socket));
}

Outcome<std::string> CommandConnection::ask(std::string_view command) {
  std::string answer;
  std::array<char, 512> buffer;
  if (send_line(socket_.get(), command)) {
    while (!answer.ends_with('\n')) {
      const auto count = receive_some(socket_.get(), buffer);
      if (count < 0 && timed_out()) return silent(path_, listener_, socket_.get(), kAnswerTimeout);
      if (count <= 0) break;
      answer.append(buffer.data(), static_cast<std::size_t>(count));
    }
  }
  if (!answer.ends_with('\n')) return failed(fmt::format("{}: the {} has ended", path_, listener_));
  answer.pop_back();
  return answer;
}

Outcome<std::string> send_command(const std::string& path, std::string_view command, std::string_view listener,
                                  std::chrono::milliseconds timeout) {
  const auto address = address_of(path);
  if (!address) return tl::unexpected(address.error());
  const auto socket = make_socket();
  if (socket.valid()) limit_waiting(socket.get(), timeout);
  if (!connect_to(socket, *address)) {
    return unreachable(path, listener, socket, timeout);
  }
  std::string answer;
  std::array<char, 512> buffer;
  if (send_line(socket.get(), command)) {
    ssize_t count = 0;
    while ((count = receive_some(socket.get(), buffer)) > 0) {
      answer.append(buffer.data(), static_cast<std::size_t>(count));
    }
    if (count < 0 && timed_out()) return silent(path, listener, socket.get(), timeout);
  }
  if (answer.empty()) return failed(fmt::format("{}: no answer", path));
  answer.pop_back();
  return answer;
}

Outcome<int> order_simulation(const std::string& path, std::string_view command, std::string_view listener) {
  const auto answer = send_command(path, command, listener);
  if (!answer) return tl::unexpected(answer.error());
  constexpr std::string_view kError = "error: ";
  if (answer->starts_with(kError)) return failed(answer->substr(kError.size()));
  print_out("{}\n", *answer);
  return 0;
}

}  // namespace driveline::cli
