#include "driveline/slaves/msd/core/scaling.hpp"

#include <cmath>
#include <limits>

namespace driveline::slaves::msd {

template <typename T>
T saturate(double value) noexcept {
  const auto low = static_cast<double>(std::numeric_limits<T>::min());
  const auto high = static_cast<double>(std::numeric_limits<T>::max());
  if (value > low && value < high) return static_cast<T>(std::lrint(value));
  if (std::isnan(value)) return T{0};
  return value <= low ? std::numeric_limits<T>::min() : std::numeric_limits<T>::max();
}

template std::int16_t saturate<std::int16_t>(double) noexcept;
template std::int32_t saturate<std::int32_t>(double) noexcept;
template std::uint32_t saturate<std::uint32_t>(double) noexcept;

}  // namespace driveline::slaves::msd
