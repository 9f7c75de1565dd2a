#pragma once

#include <cstddef>

namespace driveline::rt {

/// Distance that keeps two variables off each other's cache line: 64 bytes on x86-64 and ARMv8, doubled because x86-64
/// prefetches lines in pairs. A constant of our own because std::hardware_destructive_interference_size changes with
/// compiler flags.
inline constexpr std::size_t kCacheLineBytes = 128;

}  // namespace driveline::rt
