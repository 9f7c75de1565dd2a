#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::slaves::generic {

/// A value that follows a script instead of an application.
struct Signal {
  enum class Shape : std::uint8_t {
    kConstant,  ///< `low`
    kRamp,      ///< from `low` to `high` in a period, then from the start
    kSine,      ///< around the middle of `low` and `high`, which are its extremes
    kToggle,    ///< `low` in the first half of a period, `high` in the second
  };
  Shape shape = Shape::kConstant;
  double low = 0.0;
  double high = 0.0;
  std::chrono::nanoseconds period = std::chrono::seconds{1};  ///< above 0

  /// The value at a time from the start of the script. \rtsafe
  [[nodiscard]] double at(std::chrono::nanoseconds time) const noexcept;
};

}  // namespace driveline::slaves::generic
