#include "driveline/rt/histogram.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace driveline::rt {

using std::chrono::nanoseconds;

void Histogram::record(nanoseconds value, std::uint64_t times) noexcept {
  const nanoseconds counted = std::clamp(value, nanoseconds::zero(), kLargest);
  underflows_ += value < counted ? times : 0U;
  overflows_ += value > counted ? times : 0U;
  counts_[bucket_of(static_cast<std::uint64_t>(counted.count()))] += times;
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  sum_ns_ += static_cast<double>(value.count()) * static_cast<double>(times);
  count_ += times;
}

nanoseconds Histogram::percentile(double quantile) const noexcept {
  if (count_ == 0 || !(quantile > 0.0)) {
    return min_;
  }
  if (quantile >= 1.0) {
    return max_;
  }
  const double rank = std::ceil(quantile * static_cast<double>(count_));
  std::uint64_t passed = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    passed += counts_[i];
    if (static_cast<double>(passed) >= rank) {
      // A bucket holds the integers lower .. upper - 1. min_ and max_ narrow the first and the last occupied bucket.
      const nanoseconds middle = (lower_bound(i) + lower_bound(i + 1) - nanoseconds{1}) / 2;
      return std::clamp(middle, min_, max_);
    }
  }
  return max_;
}

double Histogram::mean_ns() const noexcept {
  return count_ == 0 ? 0.0 : sum_ns_ / static_cast<double>(count_);
}

void Histogram::merge(const Histogram& other) noexcept {
  if (other.count_ == 0) {
    return;
  }
  std::transform(counts_.begin(), counts_.end(), other.counts_.begin(), counts_.begin(), std::plus<>{});
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = count_ == 0 ? other.max_ : std::max(max_, other.max_);
  count_ += other.count_;
  underflows_ += other.underflows_;
  overflows_ += other.overflows_;
  sum_ns_ += other.sum_ns_;
}

}  // namespace driveline::rt
