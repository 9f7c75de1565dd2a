#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace driveline::slaves {

/// The value of an input that follows a script instead of a machine.
struct Signal {
  /// Unit of all times here.
  using Nanoseconds = std::chrono::nanoseconds;
  /// How the value runs over time.
  enum class Shape : std::uint8_t {
    kConstant,  ///< `low`
    kRamp,      ///< from `low` to `high` in a period, then from the start
    kSine,      ///< around the middle of `low` and `high`, which are its extremes
    kToggle,    ///< `low` in the first half of a period, `high` in the second
    kSteps,     ///< `low` until the first of `steps`, then the value of the last step that has come
  };
  /// One change of a signal of shape kSteps.
  struct Step {
    Nanoseconds at{};    ///< from the start of the script
    double value = 0.0;  ///< from then on, in the unit of the input
  };
  Shape shape = Shape::kConstant;                ///< decides which of the members below count
  double low = 0.0;                              ///< in the unit of the input
  double high = 0.0;                             ///< in the unit of the input
  Nanoseconds period = std::chrono::seconds{1};  ///< above 0
  std::vector<Step> steps{};                     ///< in order of time

  /// The value at a time from the start of the script. \rtsafe
  [[nodiscard]] double at(Nanoseconds time) const noexcept;
  /// The value only ever jumps: a digital input can follow it. \rtsafe
  [[nodiscard]] bool jumps() const noexcept { return shape != Shape::kRamp && shape != Shape::kSine; }
  /// When a signal that jumps does so next, after `time`; nothing when it stays as it is. \rtsafe
  [[nodiscard]] std::optional<Nanoseconds> next_jump(Nanoseconds time) const noexcept;
  /// Smallest and largest value it takes. \rtsafe
  [[nodiscard]] double smallest() const noexcept;
  /// See smallest(). \rtsafe
  [[nodiscard]] double largest() const noexcept;
};

}  // namespace driveline::slaves
