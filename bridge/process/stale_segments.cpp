#include "stale_segments.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace driveline::bridge {
namespace {

/// A segment is a file with this prefix and 16 hexadecimal digits; its lock has the same name followed by `_el`.
constexpr std::string_view kSegmentPrefix = "fastrtps_";
constexpr std::size_t kSegmentDigits = 16;
constexpr std::string_view kLockSuffix = "_el";

bool is_segment(std::string_view name) {
  if (!name.starts_with(kSegmentPrefix) || name.size() != kSegmentPrefix.size() + kSegmentDigits) return false;
  name.remove_prefix(kSegmentPrefix.size());
  return name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::vector<std::filesystem::path> segments_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> segments;
  std::error_code error;
  for (std::filesystem::directory_iterator entries{folder, error}, end; !error && entries != end;
       entries.increment(error)) {
    if (is_segment(entries->path().filename().native())) segments.push_back(entries->path());
  }
  return segments;
}

/// A process locks its segment before it creates it, so a segment whose lock is free belongs to a dead process.
bool remove_if_left(const std::filesystem::path& segment) {
  struct stat facts {};
  if (::lstat(segment.c_str(), &facts) != 0 || !S_ISREG(facts.st_mode) || facts.st_uid != ::geteuid()) return false;
  const auto lock = segment.native() + std::string{kLockSuffix};
  const int held = ::open(lock.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (held < 0) return false;
  const bool dead = ::flock(held, LOCK_EX | LOCK_NB) == 0;
  const bool removed = dead && ::unlink(segment.c_str()) == 0 && ::unlink(lock.c_str()) == 0;
  ::close(held);
  return removed;
}

}  // namespace

std::size_t remove_stale_segments(const std::filesystem::path& folder) {
  const auto segments = segments_in(folder);
  return static_cast<std::size_t>(std::count_if(segments.begin(), segments.end(), remove_if_left));
}

}  // namespace driveline::bridge
