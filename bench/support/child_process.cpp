#include "support/child_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

extern char** environ;

namespace driveline::bench {
namespace {

std::string content(int descriptor) {
  std::string text;
  std::array<char, 4096> part{};
  ::lseek(descriptor, 0, SEEK_SET);
  for (ssize_t length = 0; (length = ::read(descriptor, part.data(), part.size())) > 0;)
    text.append(part.data(), static_cast<std::size_t>(length));
  return text;
}

std::string last_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const auto begin = text.rfind('\n');
  return begin == std::string::npos ? text : text.substr(begin + 1);
}

std::string first_line(const std::filesystem::path& file) {
  std::string line;
  std::ifstream stream(file);
  std::getline(stream, line);
  return line;
}

}  // namespace

ChildProcess::ChildProcess(std::vector<std::string> command)
    : program_(command.front()),
      output_(::memfd_create("stdout", MFD_CLOEXEC)),
      errors_(::memfd_create("stderr", MFD_CLOEXEC)) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (auto& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output_, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors_, STDERR_FILENO);
  const int error = ::posix_spawn(&id_, program_.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == 0) return;
  ::close(output_);
  ::close(errors_);
  throw std::runtime_error(program_ + " cannot be started: " + std::generic_category().message(error));
}

ChildProcess::~ChildProcess() {
  if (!status_) {
    signal(SIGKILL);
    wait(0);
  }
  ::close(output_);
  ::close(errors_);
}

void ChildProcess::signal(int number) const noexcept {
  if (!status_) ::kill(id_, number);
}

void ChildProcess::wait(int options) {
  int status = 0;
  if (!status_ && ::waitpid(id_, &status, options) == id_) status_ = status;
}

bool ChildProcess::ended() {
  wait(WNOHANG);
  return status_.has_value();
}

std::string ChildProcess::finish() {
  wait(0);
  if (!status_ || *status_ != 0) throw std::runtime_error(program_ + " failed: " + last_line(content(errors_)));
  return content(output_);
}

std::optional<ProcessUse> use_of(pid_t process) {
  const auto folder = std::filesystem::path("/proc") / std::to_string(process);
  const auto line = first_line(folder / "stat");
  // proc(5): the name, in parentheses, may hold anything; utime and stime are fields 14 and 15.
  const auto name_end = line.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(line.substr(name_end + 1));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  double user = 0.0;
  double system = 0.0;
  fields >> user >> system;
  ProcessUse use;
  use.cpu_s = (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  std::ifstream status(folder / "status");
  constexpr double kKibPerMib = 1024.0;
  for (std::string entry; status >> entry;) {
    if (entry != "VmHWM:") continue;
    status >> use.peak_mib;
    use.peak_mib /= kKibPerMib;
  }
  return use;
}

pid_t child_named(pid_t parent, const std::string& name) {
  constexpr std::size_t kKept = 15;
  const auto wanted = name.substr(0, kKept);
  std::error_code error;
  const auto tasks = std::filesystem::path("/proc") / std::to_string(parent) / "task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) {
      if (first_line(std::filesystem::path("/proc") / std::to_string(child) / "comm") == wanted) return child;
    }
  }
  return 0;
}

}  // namespace driveline::bench
