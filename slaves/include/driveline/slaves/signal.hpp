#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace driveline::slaves {

/// Script for the value of an input, in place of a machine.
struct Signal {
  /// Unit of all times in this struct.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Course of the value over time.
  enum class Shape : std::uint8_t {
    kConstant,  ///< `low`
    kRamp,      ///< rises from `low` to `high` in each period
    kSine,      ///< oscillates between `low` and `high`
    kToggle,    ///< `low` in the first half of a period, `high` in the second
    kSteps,     ///< `low` until the first of `steps`, then the value of the latest step
  };
  /// One change of a signal of shape kSteps.
  struct Step {
    Nanoseconds at{};    ///< time from the start of the script
    double value = 0.0;  ///< value from then on, in the unit of the input
  };
  Shape shape = Shape::kConstant;                ///< selects the members that are used
  double low = 0.0;                              ///< in the unit of the input
  double high = 0.0;                             ///< in the unit of the input
  Nanoseconds period = std::chrono::seconds{1};  ///< above 0
  std::vector<Step> steps{};                     ///< in order of time

  /// Returns the value at a time from the start of the script. \rtsafe
  [[nodiscard]] double at(Nanoseconds time) const noexcept;
  /// Whether the value changes only in jumps, so that a digital input can follow it. \rtsafe
  [[nodiscard]] bool jumps() const noexcept { return shape != Shape::kRamp && shape != Shape::kSine; }
  /// Returns the time of the next jump after `time` of a signal with jumps(); nullopt when there is none. \rtsafe
  [[nodiscard]] std::optional<Nanoseconds> next_jump(Nanoseconds time) const noexcept;
  /// Returns the smallest value of the signal. \rtsafe
  [[nodiscard]] double smallest() const noexcept;
  /// Returns the largest value of the signal. \rtsafe
  [[nodiscard]] double largest() const noexcept;
};

}  // namespace driveline::slaves
