#include "helper/helper_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <thread>

namespace driveline::runtime {
namespace {

/// Value of oom_score_adj (proc(5)) of a process that the kernel ends first when memory runs out.
constexpr std::string_view kFirstToEnd = "1000";

/// Settings of the new process: its descriptors, its own process group (Ctrl-C of a terminal reaches only the parent),
/// no blocked signals.
class SpawnSettings {
 public:
  explicit SpawnSettings(const std::vector<rt::FileDescriptor>& descriptors) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (::fcntl(STDERR_FILENO, F_GETFD) >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, STDERR_FILENO, STDOUT_FILENO);
    }
    int number = HelperProcess::kSocket;
    for (const auto& descriptor : descriptors) posix_spawn_file_actions_adddup2(&actions_, descriptor.get(), number++);
    posix_spawn_file_actions_addclosefrom_np(&actions_, number);
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

HelperProcess::Transfer failure() noexcept {
  const bool not_now = errno == EAGAIN || errno == EINTR || errno == ENOBUFS;
  return not_now ? HelperProcess::Transfer::kNotNow : HelperProcess::Transfer::kEnded;
}

/// Duplicates `first` and `others` to numbers above those that they get in the new process, where a descriptor could
/// otherwise be overwritten before it is copied. Empty: too many open files.
std::vector<rt::FileDescriptor> out_of_the_way(int first, std::span<const int> others) {
  const int above = HelperProcess::kSocket + 1 + static_cast<int>(others.size());
  std::vector<rt::FileDescriptor> all;
  all.emplace_back(::fcntl(first, F_DUPFD_CLOEXEC, above));
  for (const int other : others) all.emplace_back(::fcntl(other, F_DUPFD_CLOEXEC, above));
  const bool complete = std::all_of(all.begin(), all.end(), [](const auto& each) { return each.valid(); });
  return complete ? std::move(all) : std::vector<rt::FileDescriptor>{};
}

/// When the memory of the machine or of the cgroup runs out, the kernel ends a helper, which is started again, and not
/// the process that drives the line and has more memory, all of it locked. Without the right to do so nothing changes.
void let_end_first(pid_t helper) {
  const rt::FileDescriptor file{::open(fmt::format("/proc/{}/oom_score_adj", helper).c_str(), O_WRONLY | O_CLOEXEC)};
  if (file.valid()) [[maybe_unused]]
    const auto written = ::write(file.get(), kFirstToEnd.data(), kFirstToEnd.size());
}

}  // namespace

Result<HelperProcess> HelperProcess::start(const std::filesystem::path& program, std::vector<std::string> arguments,
                                           std::span<const int> passed) {
  std::array<int, 2> ends{};
  std::string name = program.string();
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return fail(ErrorKind::kMachine, fmt::format("cannot create its socket: {}", std::strerror(errno)), name);
  }
  rt::FileDescriptor ours{ends[0]};
  const rt::FileDescriptor theirs{ends[1]};
  const auto descriptors = out_of_the_way(theirs.get(), passed);
  if (descriptors.empty()) {
    return fail(ErrorKind::kMachine, fmt::format("cannot pass its descriptors: {}", std::strerror(errno)), name);
  }
  std::vector<char*> line{name.data()};
  for (auto& argument : arguments) line.push_back(argument.data());
  line.push_back(nullptr);
  const SpawnSettings settings(descriptors);
  pid_t child = 0;
  const int refused =
      ::posix_spawn(&child, name.c_str(), settings.actions(), settings.attributes(), line.data(), environ);
  if (refused != 0) {
    return fail(ErrorKind::kMachine, fmt::format("cannot be started: {}", std::strerror(refused)), name);
  }
  let_end_first(child);
  return HelperProcess(std::move(ours), child);
}

HelperProcess& HelperProcess::operator=(HelperProcess&& other) noexcept {
  if (this == &other) return *this;
  end();
  socket_ = std::move(other.socket_);
  child_ = std::exchange(other.child_, 0);
  return *this;
}

HelperProcess::Transfer HelperProcess::send(std::span<const std::byte> message) noexcept {
  const auto sent = ::send(socket_.get(), message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent >= 0 ? Transfer::kDone : failure();
}

HelperProcess::Transfer HelperProcess::receive(std::span<std::byte> room, std::size_t& length) noexcept {
  const auto received = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (received < 0) return failure();
  length = static_cast<std::size_t>(received);
  return length == 0 ? Transfer::kEnded : Transfer::kDone;
}

void HelperProcess::finish() noexcept {
  if (socket_.valid()) ::shutdown(socket_.get(), SHUT_WR);
}

void HelperProcess::kill() noexcept {
  if (child_ != 0) ::kill(child_, SIGKILL);
}

std::optional<int> HelperProcess::reap() noexcept {
  int status = 0;
  if (child_ == 0) return std::nullopt;
  const pid_t ended = ::waitpid(child_, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
  child_ = 0;  // also if other code has already waited for it
  socket_ = rt::FileDescriptor{};
  return status;
}

std::optional<int> HelperProcess::end(std::chrono::milliseconds timeout) noexcept {
  socket_ = rt::FileDescriptor{};
  const auto limit = std::chrono::steady_clock::now() + timeout;
  bool forced = false;
  while (child_ != 0) {
    if (const auto status = reap()) return status;
    if (!forced && std::chrono::steady_clock::now() >= limit) {
      kill();
      forced = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return std::nullopt;
}

std::string describe_end(int wait_status) {
  if (WIFSIGNALED(wait_status)) return fmt::format("signal {}", WTERMSIG(wait_status));
  return fmt::format("status {}", WEXITSTATUS(wait_status));
}

}  // namespace driveline::runtime
