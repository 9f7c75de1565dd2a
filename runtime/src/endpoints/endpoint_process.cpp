#include "endpoints/endpoint_process.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

namespace driveline::runtime {
namespace {

using port::FileDescriptor;

/// Descriptor of the socket in the end point.
constexpr int kSocket = 3;
/// Until an end point whose socket is closed is ended with force.
constexpr std::chrono::milliseconds kPatience{1000};

/// What the new process is to differ in: the socket, a process group of its own (Ctrl-C of a terminal is for this
/// process alone), no blocked signals.
class SpawnSettings {
 public:
  explicit SpawnSettings(int socket) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, socket, kSocket);
    posix_spawnattr_init(&attributes_);
    sigset_t none{};
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  [[nodiscard]] const posix_spawn_file_actions_t* actions() const noexcept { return &actions_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const noexcept { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

EndpointProcess::Transfer failure() noexcept {
  const bool not_now = errno == EAGAIN || errno == EINTR || errno == ENOBUFS;
  return not_now ? EndpointProcess::Transfer::kNotNow : EndpointProcess::Transfer::kEnded;
}

}  // namespace

Result<EndpointProcess> EndpointProcess::start(const std::filesystem::path& program) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return fail(ErrorKind::kMachine, std::strerror(errno), "socket to an end point");
  }
  FileDescriptor ours{ends[0]};
  const FileDescriptor theirs{ends[1]};
  std::string name = program.string();
  std::string option = "--socket";
  std::string number = std::to_string(kSocket);
  std::array<char*, 4> line{name.data(), option.data(), number.data(), nullptr};
  const SpawnSettings settings(theirs.get());
  pid_t child = 0;
  const int refused =
      ::posix_spawn(&child, name.c_str(), settings.actions(), settings.attributes(), line.data(), environ);
  if (refused != 0) {
    return fail(ErrorKind::kMachine, fmt::format("cannot be started: {}", std::strerror(refused)), name);
  }
  return EndpointProcess(std::move(ours), child);
}

EndpointProcess& EndpointProcess::operator=(EndpointProcess&& other) noexcept {
  if (this == &other) return *this;
  end();
  socket_ = std::move(other.socket_);
  child_ = std::exchange(other.child_, 0);
  return *this;
}

EndpointProcess::Transfer EndpointProcess::send(const slaves::EndpointPacket& packet) noexcept {
  const auto bytes = packet.bytes();
  const auto sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent >= 0 ? Transfer::kDone : failure();
}

EndpointProcess::Transfer EndpointProcess::receive(slaves::EndpointPacket& packet) noexcept {
  const auto room = packet.room();
  const auto length = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (length < 0) return failure();
  packet.set_length(static_cast<std::size_t>(length));
  return length == 0 ? Transfer::kEnded : Transfer::kDone;
}

void EndpointProcess::end() noexcept {
  socket_ = FileDescriptor{};
  if (child_ == 0) return;
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  bool forced = false;
  while (::waitpid(child_, nullptr, WNOHANG) == 0) {
    if (!forced && std::chrono::steady_clock::now() > limit) forced = ::kill(child_, SIGKILL) == 0;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  child_ = 0;
}

}  // namespace driveline::runtime
