#pragma once

#include <algorithm>
#include <cmath>

/// Parameters and inputs of the models, kept where the models are stable. \rtsafe
namespace driveline::slaves {

/// What is not finite counts as 0.
inline double finite(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

/// `value`, but no less than `low`, which also stands for what is not finite.
inline double at_least(double value, double low) noexcept {
  return std::isfinite(value) ? std::max(value, low) : low;
}

/// `value` brought into low..high; `fallback` for what is not finite.
inline double in_range(double value, double low, double high, double fallback) noexcept {
  return std::isfinite(value) ? std::clamp(value, low, high) : fallback;
}

}  // namespace driveline::slaves
