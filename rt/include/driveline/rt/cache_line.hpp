#pragma once

#include <cstddef>

namespace driveline::rt {

/// Alignment that keeps two variables on separate cache lines: 64 bytes on x86-64 and ARMv8, doubled because x86-64
/// prefetches lines in pairs. A fixed constant because std::hardware_destructive_interference_size changes with
/// compiler flags.
inline constexpr std::size_t kCacheLineBytes = 128;

}  // namespace driveline::rt
