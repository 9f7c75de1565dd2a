#pragma once

#include <algorithm>
#include <cmath>

/// Parameters and inputs of the models, kept where the models are stable. \rtsafe
namespace driveline::slaves {

/// 0 for values that are not finite.
inline double finite(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

/// `value`, at least `low`; `low` for values that are not finite.
inline double at_least(double value, double low) noexcept {
  return std::isfinite(value) ? std::max(value, low) : low;
}

/// `value` limited to low..high; `fallback` for values that are not finite.
inline double in_range(double value, double low, double high, double fallback) noexcept {
  return std::isfinite(value) ? std::clamp(value, low, high) : fallback;
}

}  // namespace driveline::slaves
