#pragma once

#include <ctime>

namespace driveline::bench {

/// CLOCK_MONOTONIC in nanoseconds, whatever clock the measured system runs on.
[[nodiscard]] inline double now_ns() noexcept {
  std::timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

/// The cost of one reading of now_ns(): the median difference of two readings in a row. Measured once.
[[nodiscard]] double reading_cost_ns();

/// Keeps the compiler from removing the calculation of `value`.
template <typename T>
inline void keep(const T& value) noexcept {
  asm volatile("" : : "r"(&value) : "memory");
}

}  // namespace driveline::bench
