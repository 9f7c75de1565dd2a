#pragma once

#include <algorithm>
#include <chrono>

namespace driveline::runtime {

/// So many in a second, and a few more at once after a pause.
class RateLimit {
 public:
  /// `per_second` and `at_once`: positive. All of `at_once` may come at the beginning.
  constexpr RateLimit(double per_second, double at_once) noexcept
      : per_second_(per_second), at_once_(at_once), left_(at_once) {}

  /// One more, at that time of a clock that does not go back. False: it is too many.
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
