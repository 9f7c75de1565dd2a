#pragma once

#include <cstddef>
#include <filesystem>

namespace driveline::bridge {

/// Removes the segments of Fast DDS in `folder` whose processes have died, as far as they belong to this user: a bridge
/// that is killed leaves one, and the next one makes another. How many there were.
std::size_t remove_left_segments(const std::filesystem::path& folder = "/dev/shm");

}  // namespace driveline::bridge
