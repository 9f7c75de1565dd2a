#include "support/child_program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

extern char** environ;

namespace driveline::bench {

ChildProgram::ChildProgram(pid_t process, port::FileDescriptor out, std::string name)
    : process_(process), out_(std::move(out)), name_(std::move(name)) {}

std::unique_ptr<ChildProgram> ChildProgram::start(std::vector<std::string> words) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe to read from");
  port::FileDescriptor out{ends[0]};
  const port::FileDescriptor in{ends[1]};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.get(), STDOUT_FILENO);
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t process = -1;
  const int refused = posix_spawnp(&process, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused == ENOENT) return nullptr;
  if (refused != 0)
    throw std::runtime_error(fmt::format("{}: cannot be started: {}", words[0], std::strerror(refused)));
  return std::unique_ptr<ChildProgram>(new ChildProgram(process, std::move(out), words[0]));
}

ChildProgram::~ChildProgram() {
  if (process_ < 0) return;
  kill(process_, SIGTERM);
  wait();
}

int ChildProgram::wait() noexcept {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

bool ChildProgram::has_ended() noexcept {
  if (process_ >= 0 && waitpid(process_, nullptr, WNOHANG) == process_) process_ = -1;
  return process_ < 0;
}

std::string ChildProgram::finish() {
  std::string text;
  std::array<char, 4096> part{};
  for (ssize_t size = 0; (size = read(out_.get(), part.data(), part.size())) != 0;) {
    if (size > 0) text.append(part.data(), static_cast<std::size_t>(size));
    if (size < 0 && errno != EINTR) break;
  }
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(fmt::format("{} failed (status {}): {}", name_, status, text));
  return text;
}

}  // namespace driveline::bench
