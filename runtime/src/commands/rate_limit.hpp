#pragma once

#include <algorithm>
#include <chrono>

namespace driveline::runtime {

/// Limits a rate: a number per second, and a larger burst after a pause.
class RateLimit {
 public:
  /// `per_second` and `at_once`: positive. The first burst may have `at_once` elements.
  constexpr RateLimit(double per_second, double at_once) noexcept
      : per_second_(per_second), at_once_(at_once), left_(at_once) {}

  /// Counts one more at time `now` of a monotonic clock. False: the limit is exceeded.
  [[nodiscard]] constexpr bool take(std::chrono::nanoseconds now) noexcept {
    if (!begun_ || now < last_) last_ = now;
    begun_ = true;
    left_ = std::min(at_once_, left_ + std::chrono::duration<double>(now - last_).count() * per_second_);
    last_ = now;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  double per_second_;
  double at_once_;
  double left_;
  bool begun_ = false;
  std::chrono::nanoseconds last_{};
};

}  // namespace driveline::runtime
