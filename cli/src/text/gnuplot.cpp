#include "text/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "driveline/runtime/files/output_file.hpp"
#include "text/visible_text.hpp"

extern char** environ;

namespace driveline::cli {
namespace {

/// Reads until the other end closes, and returns the last line that is not blank.
std::string last_line(int end) {
  std::string line;
  std::string last;
  std::array<char, 4096> part{};
  for (ssize_t size = 0; (size = read(end, part.data(), part.size())) != 0;) {
    if (size < 0 && errno != EINTR) break;
    for (const char c : std::string_view(part.data(), size < 0 ? 0 : static_cast<std::size_t>(size))) {
      if (c != '\n') {
        line += c;
        continue;
      }
      if (line.find_first_not_of(" \t^") != std::string::npos) last = line;
      line.clear();
    }
  }
  return line.find_first_not_of(" \t^") == std::string::npos ? last : line;
}

/// Whether a PNG file is complete: it ends with the type and the checksum of its last chunk (ISO/IEC 15948, 11.2.5). A
/// device or a pipe, which gnuplot writes in place, counts as complete: there is nothing to check.
bool is_whole(const std::filesystem::path& picture) {
  std::error_code ignored;
  if (std::filesystem::is_other(picture, ignored)) return true;
  constexpr std::string_view kEnd("IEND\xAE\x42\x60\x82", 8);
  std::ifstream stream(picture, std::ios::binary);
  if (!stream.seekg(-static_cast<std::streamoff>(kEnd.size()), std::ios::end)) return false;
  return std::string(std::istreambuf_iterator<char>(stream), {}) == kEnd;
}

}  // namespace

std::string gnuplot_text(std::string_view name) {
  std::string text = "'";
  for (const char c : visible_text(name)) {
    const bool line_end = c == '\n' || c == '\t';
    text += line_end ? ' ' : c;
    if (c == '\'') text += c;
  }
  return text + "'";
}

tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory, const std::string& script) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    posix_spawn_file_actions_destroy(&actions);
    return tl::unexpected(fmt::format("no plots: {}", std::strerror(errno)));
  }
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  std::string program = "gnuplot";
  std::string argument = script;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  pid_t pid = 0;
  const int failed = posix_spawnp(&pid, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  const auto said = failed == 0 ? last_line(ends[0]) : std::string{};
  close(ends[0]);
  if (failed != 0)
    return tl::unexpected(std::string("no plots: gnuplot is not installed (Debian package gnuplot-nox)"));
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return tl::unexpected(fmt::format("no plots: gnuplot failed on {}{}{}", (directory / script).string(),
                                      said.empty() ? "" : ": ", said));
  }
  return {};
}

tl::expected<Drawing, std::string> draw(const std::filesystem::path& directory, const std::string& name,
                                        const std::string& script, const std::map<std::string, std::string>& pictures) {
  Drawing drawing;
  if (auto written = runtime::write_file(directory / name, script); !written) {
    drawing.problem = written.error();
    return drawing;
  }
  if (auto drawn = run_gnuplot(directory, name); !drawn) return tl::unexpected(drawn.error());
  for (const auto& [key, picture] : pictures) {
    const auto file = directory / picture;
    if (is_whole(file)) {
      drawing.pictures[key] = file;
      continue;
    }
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    if (drawing.problem) continue;
    drawing.problem =
        runtime::fail(
            runtime::ErrorKind::kMachine,
            "could not be written completely: the disk is full, or the file size limit is reached (ulimit -f)",
            file.string())
            .value();
  }
  return drawing;
}

}  // namespace driveline::cli
