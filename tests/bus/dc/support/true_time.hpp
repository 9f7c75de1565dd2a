#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>

/// Arithmetic of the tests of clocks, independent of the master's (ecat_master/dc/system_time.hpp): an error in shared
/// arithmetic would cancel out.
namespace driveline::bus_test {

/// How far `distance` is from the nearest multiple of `period`.
[[nodiscard]] inline std::chrono::nanoseconds off_beat(std::chrono::nanoseconds distance,
                                                       std::chrono::nanoseconds period) {
  // 64 bits of mantissa hold every number of nanoseconds.
  static_assert(std::numeric_limits<long double>::digits >= 64);
  const auto rest =
      std::remainder(static_cast<long double>(distance.count()), static_cast<long double>(period.count()));
  return std::chrono::nanoseconds{static_cast<std::int64_t>(rest)};
}

/// By how much system time `a` is ahead of `b`; both begin at power-on and are decades from their ends.
[[nodiscard]] inline std::chrono::nanoseconds ahead_of(std::uint64_t a, std::uint64_t b) {
  return a < b ? -std::chrono::nanoseconds{static_cast<std::int64_t>(b - a)}
               : std::chrono::nanoseconds{static_cast<std::int64_t>(a - b)};
}

}  // namespace driveline::bus_test
