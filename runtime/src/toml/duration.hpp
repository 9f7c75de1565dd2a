#pragma once

#include <chrono>
#include <cmath>

namespace driveline::runtime {

/// Converts a duration of a line description, which is a number of microseconds.
[[nodiscard]] inline std::chrono::nanoseconds from_us(double us) {
  return std::chrono::nanoseconds{std::llround(us * 1000.0)};
}

}  // namespace driveline::runtime
