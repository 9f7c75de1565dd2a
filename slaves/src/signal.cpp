#include "driveline/slaves/signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::slaves {
namespace {

using Steps = std::vector<Signal::Step>;

/// Returns the first step after `time`.
Steps::const_iterator step_after(const Steps& steps, Signal::Nanoseconds time) noexcept {
  return std::upper_bound(steps.begin(), steps.end(), time,
                          [](Signal::Nanoseconds t, const Signal::Step& step) { return t < step.at; });
}

}  // namespace

double Signal::at(Nanoseconds time) const noexcept {
  if (shape == Shape::kSteps) {
    const auto next = step_after(steps, time);
    return next == steps.begin() ? low : std::prev(next)->value;
  }
  // The remainder is computed in whole nanoseconds, so that a script keeps its phase for days.
  const double phase = static_cast<double>((time % period).count()) / static_cast<double>(period.count());
  switch (shape) {
    case Shape::kRamp:
      return low + (high - low) * phase;
    case Shape::kSine:
      return 0.5 * (low + high) + 0.5 * (high - low) * std::sin(2.0 * std::numbers::pi * phase);
    case Shape::kToggle:
      return phase < 0.5 ? low : high;
    case Shape::kConstant:
    case Shape::kSteps:
      break;
  }
  return low;
}

std::optional<Signal::Nanoseconds> Signal::next_jump(Nanoseconds time) const noexcept {
  if (shape == Shape::kSteps) {
    const auto next = step_after(steps, time);
    return next == steps.end() ? std::nullopt : std::optional(next->at);
  }
  if (shape != Shape::kToggle) return std::nullopt;
  // Consistent with at(): the second half starts where the phase reaches one half.
  const auto begin = time - time % period;
  const auto middle = begin + (period + Nanoseconds{1}) / 2;
  return time < middle ? middle : begin + period;
}

double Signal::smallest() const noexcept {
  double value = shape == Shape::kConstant || shape == Shape::kSteps ? low : std::min(low, high);
  for (const Step& step : steps) value = std::min(value, step.value);
  return value;
}

double Signal::largest() const noexcept {
  double value = shape == Shape::kConstant || shape == Shape::kSteps ? low : std::max(low, high);
  for (const Step& step : steps) value = std::max(value, step.value);
  return value;
}

}  // namespace driveline::slaves
