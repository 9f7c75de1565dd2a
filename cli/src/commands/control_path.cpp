#include "commands/control_path.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "commands/command_input.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kSocketSuffix = ".socket";

/// The name of a line as a file name: letters, digits, '-', '_', and '.' except at the start; other characters as %XX.
std::string file_name(const std::string& line) {
  std::string name;
  for (const char c : line) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (letter || c == '-' || c == '_' || (c == '.' && !name.empty())) {
      name += c;
    } else {
      name += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return name;
}

}  // namespace

std::filesystem::path control_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && *runtime == '/') return std::filesystem::path(runtime) / "driveline";
  if (::geteuid() == 0) return "/run/driveline";
  return fmt::format("/tmp/driveline-{}", ::geteuid());
}

Outcome<void> make_control_folder() {
  const auto folder = control_folder();
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return failed(fmt::format("{}: cannot be made: {}", folder.string(), std::strerror(errno)));
  }
  struct stat found = {};
  if (::lstat(folder.c_str(), &found) != 0) {
    return failed(fmt::format("{}: {}", folder.string(), std::strerror(errno)));
  }
  if (!S_ISDIR(found.st_mode) || found.st_uid != ::geteuid() || (found.st_mode & 0077) != 0) {
    return failed(fmt::format("{}: must be a folder that only this user can access (mode 0700)", folder.string()));
  }
  return {};
}

std::filesystem::path control_path(const std::string& line) {
  return control_folder() / (file_name(line) + std::string(kSocketSuffix));
}

std::vector<std::filesystem::path> running_lines() {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(control_folder(), error)) {
    if (entry.path().extension() == kSocketSuffix && listener_at(entry.path())) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

Outcome<std::string> find_control(const std::string& control, const std::string& config) {
  if (!control.empty()) return control;
  if (!config.empty()) {
    const auto read = runtime::load_line_config(config);
    if (!read) return tl::unexpected(Failure(read.error()));
    const auto path = control_path(read->name);
    if (listener_at(path)) return path.string();
    return failed(fmt::format("line \"{}\" does not run: no process listens at {}", read->name, path.string()));
  }
  const auto running = running_lines();
  if (running.size() == 1) return running.front().string();
  if (running.empty()) {
    return failed(
        fmt::format("no line runs: no process listens in {}; `driveline run` listens there or at --control PATH",
                    control_folder().string()));
  }
  std::vector<std::string> names;
  for (const auto& path : running) names.push_back(path.string());
  return misused(
      fmt::format("several lines run: give --config FILE or --control PATH; {} run", fmt::join(names, ", ")));
}

std::string running_control(const std::string& config) {
  if (config.empty()) {
    const auto running = running_lines();
    return running.size() == 1 ? running.front().string() : std::string{};
  }
  // Ignore errors in the file here: opening the line reports them.
  const auto read = runtime::load_line_config(config);
  if (!read) return {};
  const auto path = control_path(read->name);
  return listener_at(path) ? path.string() : std::string{};
}

}  // namespace driveline::cli
