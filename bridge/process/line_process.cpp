#include "line_process.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace driveline::bridge {
namespace {

namespace fs = std::filesystem;

/// A region of the feed among the descriptors of a process, with the name given by FeedWriter and BridgeSupervisor.
struct Region {
  std::string_view name;
  int flags;
};

/// In the order of `--feed-fd`, then `--condition-fd` and `--return-fd`, which exists for the bridge of a service.
constexpr std::array<Region, 6> kRegions{{{"description", O_RDONLY},
                                          {"status", O_RDONLY},
                                          {"cycles", O_RDONLY},
                                          {"events", O_RDONLY},
                                          {"condition", O_RDONLY},
                                          {"service", O_RDWR}}};
constexpr std::size_t kConditionRegion = 4;
constexpr std::size_t kCountsRegion = 5;
/// First descriptor for the regions in this process. A process that has just started has none this high.
constexpr int kFirstDescriptor = 40;

/// Prefix and suffix of the link targets of memfds (proc(5)).
constexpr std::string_view kPrefix = "/memfd:driveline-feed-";
constexpr std::string_view kSuffix = " (deleted)";

/// Index in kRegions of the target of a descriptor's link; kRegions.size(): not a region of a feed.
std::size_t region_of(const std::string& target) {
  const std::string_view text = target;
  std::size_t at = 0;
  if (!text.starts_with(kPrefix) || !text.ends_with(kSuffix)) return kRegions.size();
  const auto name = text.substr(kPrefix.size(), text.size() - kPrefix.size() - kSuffix.size());
  while (at < kRegions.size() && kRegions[at].name != name) ++at;
  return at;
}

/// Returns false if it cannot be opened; errno has the reason.
bool open_at(const fs::path& link, int flags, int wanted) {
  const int opened = ::open(link.c_str(), flags | O_CLOEXEC);
  if (opened < 0) return false;
  const bool moved = ::dup3(opened, wanted, O_CLOEXEC) == wanted;
  ::close(opened);
  return moved;
}

}  // namespace

std::string take_feed_of_process(Options& options) {
  const auto process = "process " + std::to_string(options.process);
  const auto folder = fs::path{"/proc"} / std::to_string(options.process) / "fd";
  std::error_code error;
  if (!fs::exists(folder.parent_path(), error)) return process + " is not there";
  fs::directory_iterator links{folder, error};
  if (error)
    return process + ": its descriptors cannot be read (" + error.message() +
           "): only root and the user of the process may read them";
  std::array<bool, kRegions.size()> found{};
  for (; links != fs::directory_iterator{}; links.increment(error)) {
    const auto region = region_of(fs::read_symlink(links->path(), error).string());
    if (region == kRegions.size()) continue;
    const auto& [name, flags] = kRegions[region];
    if (!open_at(links->path(), flags, kFirstDescriptor + static_cast<int>(region))) {
      return process + ": feed " + std::string{name} + ": " + std::strerror(errno);
    }
    found[region] = true;
  }
  for (std::size_t region = 0; region < kCountsRegion; ++region) {
    if (found[region]) continue;
    return process + " publishes no telemetry: it has no feed " + std::string{kRegions[region].name};
  }
  options.feed = kFirstDescriptor;
  options.condition = kFirstDescriptor + static_cast<int>(kConditionRegion);
  // If `run` has started a bridge itself, there is no such region: the counts belong to that bridge.
  if (found[kCountsRegion]) options.counts = kFirstDescriptor + static_cast<int>(kCountsRegion);
  return {};
}

}  // namespace driveline::bridge
