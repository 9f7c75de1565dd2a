// Restricts a bridge with shared memory to files in /dev/shm, by Landlock (Linux 5.13, landlock(7)).
#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "confinement.hpp"

namespace driveline::bridge {
namespace {

constexpr const char* kSharedFolder = "/dev/shm";

/// Rights that each Landlock version can restrict, indexed by version - 1. Numeric values are used because the header
/// may be older than the kernel, or newer. A ruleset cannot restrict other rights.
constexpr std::uint64_t kFirstRights = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1U;
constexpr std::uint64_t kRefer = 1U << 13U;
constexpr std::uint64_t kTruncate = 1U << 14U;
constexpr std::uint64_t kDeviceCommands = 1U << 15U;
constexpr std::array<std::uint64_t, 5> kKnownRights{
    kFirstRights, kFirstRights | kRefer, kFirstRights | kRefer | kTruncate, kFirstRights | kRefer | kTruncate,
    kFirstRights | kRefer | kTruncate | kDeviceCommands};

/// Rights on the files in /dev/shm: segments, ports, and their locks.
constexpr std::uint64_t kRightsThere = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                                       LANDLOCK_ACCESS_FS_READ_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                                       LANDLOCK_ACCESS_FS_REMOVE_FILE | kTruncate;

class Descriptor {
 public:
  explicit Descriptor(long number) : number_(static_cast<int>(number)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// Landlock version of the kernel; 0: not available, or disabled.
std::size_t landlock_version() {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version > 0 ? static_cast<std::size_t>(version) : 0;
}

}  // namespace

FileLimits limit_files_to_shared_memory() {
  const auto version = landlock_version();
  if (version == 0) return FileLimits::kNone;
  const auto rights = kKnownRights[version < kKnownRights.size() ? version - 1 : kKnownRights.size() - 1];
  landlock_ruleset_attr attributes{};
  attributes.handled_access_fs = rights;
  const Descriptor ruleset{
      ::syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes.handled_access_fs), 0)};
  const Descriptor folder{::open(kSharedFolder, O_PATH | O_DIRECTORY | O_CLOEXEC)};
  landlock_path_beneath_attr beneath{};
  beneath.allowed_access = kRightsThere & rights;
  beneath.parent_fd = folder.number();
  const bool limited =
      ruleset.number() >= 0 && folder.number() >= 0 &&
      ::syscall(SYS_landlock_add_rule, ruleset.number(), LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) == 0 &&
      ::syscall(SYS_landlock_restrict_self, ruleset.number(), 0) == 0;
  return limited ? FileLimits::kSharedMemory : FileLimits::kNone;
}

}  // namespace driveline::bridge
