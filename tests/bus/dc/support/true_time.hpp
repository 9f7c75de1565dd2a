#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>

/// Arithmetic for tests of clocks, independent of the master's (ecat_master/dc/system_time.hpp): an error in shared
/// arithmetic would cancel out.
namespace driveline::bus_test {

/// Distance of `distance` from the nearest multiple of `period`.
[[nodiscard]] inline std::chrono::nanoseconds off_beat(std::chrono::nanoseconds distance,
                                                       std::chrono::nanoseconds period) {
  // 64 bits of mantissa represent every number of nanoseconds.
  static_assert(std::numeric_limits<long double>::digits >= 64);
  const auto rest =
      std::remainder(static_cast<long double>(distance.count()), static_cast<long double>(period.count()));
  return std::chrono::nanoseconds{static_cast<std::int64_t>(rest)};
}

/// Lead of system time `a` over `b`; both start at power-on and are decades away from an overflow.
[[nodiscard]] inline std::chrono::nanoseconds ahead_of(std::uint64_t a, std::uint64_t b) {
  return a < b ? -std::chrono::nanoseconds{static_cast<std::int64_t>(b - a)}
               : std::chrono::nanoseconds{static_cast<std::int64_t>(a - b)};
}

}  // namespace driveline::bus_test
