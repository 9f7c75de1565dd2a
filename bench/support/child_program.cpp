#include "support/child_program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

extern char** environ;

namespace driveline::bench {
namespace {

std::string content(const rt::FileDescriptor& file) {
  std::string text;
  std::array<char, 4096> part{};
  lseek(file.get(), 0, SEEK_SET);
  for (ssize_t length = 0; (length = read(file.get(), part.data(), part.size())) > 0;)
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

ChildProgram::ChildProgram(std::string name, rt::FileDescriptor output, rt::FileDescriptor errors)
    : name_(std::move(name)), output_(std::move(output)), errors_(std::move(errors)) {}

std::unique_ptr<ChildProgram> ChildProgram::start(std::vector<std::string> words) {
  std::unique_ptr<ChildProgram> child(new ChildProgram(words[0],
                                                       rt::FileDescriptor{memfd_create("stdout", MFD_CLOEXEC)},
                                                       rt::FileDescriptor{memfd_create("stderr", MFD_CLOEXEC)}));
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, child->output_.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, child->errors_.get(), STDERR_FILENO);
  pid_t process = -1;
  const int refused = posix_spawnp(&process, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused == ENOENT) return nullptr;
  if (refused != 0)
    throw std::runtime_error(
        fmt::format("{}: cannot be started: {}", words[0], std::generic_category().message(refused)));
  child->process_ = process;
  return child;
}

ChildProgram::~ChildProgram() {
  signal(SIGTERM);
  wait(0);
}

void ChildProgram::signal(int number) const noexcept {
  if (process_ > 0 && !status_) kill(process_, number);
}

void ChildProgram::wait(int options) noexcept {
  if (process_ < 0 || status_) return;
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(process_, &status, options)) < 0 && errno == EINTR) {
  }
  if (ended == process_) status_ = status;
}

bool ChildProgram::has_ended() noexcept {
  wait(WNOHANG);
  return status_.has_value();
}

std::string ChildProgram::finish() {
  wait(0);
  if (!status_ || !WIFEXITED(*status_) || WEXITSTATUS(*status_) != 0)
    throw std::runtime_error(fmt::format("{} failed: {}", name_, last_line(content(errors_))));
  return content(output_);
}

std::optional<ProcessUse> use_of(pid_t process) {
  const auto folder = std::filesystem::path("/proc") / std::to_string(process);
  const auto line = first_line(folder / "stat");
  // proc(5): the name, in parentheses, may contain any character; utime and stime are fields 14 and 15.
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
