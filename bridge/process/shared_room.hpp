#pragma once

#include <sys/statvfs.h>

#include <cstdint>

namespace driveline::bridge {

/// Free bytes that shared memory needs in its folder: the segment of this process, and its locks.
inline constexpr std::uint64_t kSharedRoomBytes = 512 * 1024;

/// Whether the file system with these figures has kSharedRoomBytes left for a process without privileges. Fast DDS
/// creates its segment as a file with holes, so without room the first access to it is a SIGBUS. A tmpfs without a
/// limit reports no blocks at all.
[[nodiscard]] constexpr bool has_shared_room(const struct statvfs& facts) noexcept {
  return facts.f_blocks == 0 || std::uint64_t{facts.f_bavail} * facts.f_frsize >= kSharedRoomBytes;
}

/// Whether /dev/shm has room. True also if its figures cannot be read: Fast DDS then reports what is missing.
[[nodiscard]] bool shared_memory_has_room() noexcept;

}  // namespace driveline::bridge
