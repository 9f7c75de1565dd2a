#include "driveline/slaves/cia402/ratio.hpp"

#include <algorithm>
#include <limits>

namespace driveline::slaves {
namespace {

constexpr Ratio::Wide greatest_common_divisor(Ratio::Wide a, Ratio::Wide b) noexcept {
  while (b != 0) {
    const Ratio::Wide rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

constexpr auto kMax = std::numeric_limits<std::int64_t>::max();

}  // namespace

Ratio::Ratio(std::int64_t numerator, std::int64_t divisor) noexcept
    : numerator_(numerator), divisor_(divisor), short_way_((kMax - divisor) / numerator) {}

Ratio Ratio::of(Wide numerator, Wide divisor) noexcept {
  Wide n = std::max<Wide>(numerator, 1);
  Wide d = std::max<Wide>(divisor, 1);
  const Wide common = greatest_common_divisor(n, d);
  n /= common;
  d /= common;
  while (n > static_cast<Wide>(kMax) || d > static_cast<Wide>(kMax)) {
    n >>= 1U;
    d >>= 1U;
  }
  return {std::max<std::int64_t>(static_cast<std::int64_t>(n), 1),
          std::max<std::int64_t>(static_cast<std::int64_t>(d), 1)};
}

Ratio Ratio::inverse() const noexcept {
  return {divisor_, numerator_};
}

std::int64_t Ratio::multiplied(std::int64_t value) const noexcept {
  const std::int64_t half = divisor_ / 2;
  if (value <= short_way_ && value >= -short_way_) {
    const std::int64_t product = value * numerator_;
    return (product + (product < 0 ? -half : half)) / divisor_;
  }
  const bool negative = value < 0;
  const Wide magnitude = negative ? Wide{0} - static_cast<Wide>(value) : static_cast<Wide>(value);
  const Wide result =
      (magnitude * static_cast<Wide>(numerator_) + static_cast<Wide>(half)) / static_cast<Wide>(divisor_);
  const auto limited = static_cast<std::int64_t>(std::min<Wide>(result, static_cast<Wide>(kMax)));
  return negative ? -limited : limited;
}

PositionRangeLimit::PositionRangeLimit(std::int32_t minimum, std::int32_t maximum) noexcept {
  if (minimum >= maximum) return;
  minimum_ = minimum;
  size_ = std::int64_t{maximum} - minimum + 1;
}

std::int64_t PositionRangeLimit::destination(std::int64_t position, std::int32_t target,
                                             Direction direction) const noexcept {
  const std::int64_t up = positive_distance(position, target);
  switch (direction) {
    case Direction::kPositive:
      return position + up;
    case Direction::kNegative:
      return up == 0 ? position : position + up - size_;
    case Direction::kShortest:
      return nearest(position, target);
    case Direction::kLinear:
      break;
  }
  return position + (std::int64_t{wrap(target)} - wrap(position));
}

}  // namespace driveline::slaves
