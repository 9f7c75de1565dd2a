#pragma once

#include <algorithm>
#include <cmath>

/// Limits of parameters and inputs to the range where the models are stable. \rtsafe
namespace driveline::slaves {

/// Returns 0 for a value that is not finite.
inline double finite(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

/// Returns `value`, at least `low`; `low` for a value that is not finite.
inline double at_least(double value, double low) noexcept {
  return std::isfinite(value) ? std::max(value, low) : low;
}

/// Returns `value` limited to low..high; `fallback` for a value that is not finite.
inline double in_range(double value, double low, double high, double fallback) noexcept {
  return std::isfinite(value) ? std::clamp(value, low, high) : fallback;
}

}  // namespace driveline::slaves
