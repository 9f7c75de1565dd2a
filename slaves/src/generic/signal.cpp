#include "driveline/slaves/generic/signal.hpp"

#include <cmath>
#include <numbers>

namespace driveline::slaves::generic {

double Signal::at(std::chrono::nanoseconds time) const noexcept {
  // The remainder is taken in whole nanoseconds: a script does not lose its phase after days.
  const double phase = static_cast<double>((time % period).count()) / static_cast<double>(period.count());
  switch (shape) {
    case Shape::kConstant:
      return low;
    case Shape::kRamp:
      return low + (high - low) * phase;
    case Shape::kSine:
      return 0.5 * (low + high) + 0.5 * (high - low) * std::sin(2.0 * std::numbers::pi * phase);
    case Shape::kToggle:
      return phase < 0.5 ? low : high;
  }
  return low;
}

}  // namespace driveline::slaves::generic
