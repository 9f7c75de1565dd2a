#pragma once

#include <cstddef>
#include <filesystem>

namespace driveline::bridge {

/// Removes the Fast DDS segments of dead processes in `folder`, as far as they belong to this user: a bridge that is
/// killed leaves one behind, and the next one creates another. Returns their number.
std::size_t remove_stale_segments(const std::filesystem::path& folder = "/dev/shm");

}  // namespace driveline::bridge
