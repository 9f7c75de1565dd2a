#pragma once

#include <ctime>

namespace driveline::bench {

/// CLOCK_MONOTONIC in nanoseconds, independent of the clock of the measured system.
[[nodiscard]] inline double now_ns() noexcept {
  std::timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

/// The cost of a reading of now_ns(): the median difference of two consecutive readings. Measured once.
[[nodiscard]] double reading_cost_ns();

/// Keeps the compiler from removing the calculation of `value`.
template <typename T>
inline void keep(const T& value) noexcept {
  asm volatile("" : : "r"(&value) : "memory");
}

}  // namespace driveline::bench
