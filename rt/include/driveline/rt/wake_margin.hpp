#pragma once

#include <algorithm>
#include <chrono>

namespace driveline::rt {

/// How long before an instant a thread is to wake so that it runs by then: follows what wake-ups of this thread on this
/// machine take, so that 99 of 100 are over in time. Belongs to one thread. \rtsafe
///
/// A step up for each wake-up that took longer, a small one down for each that did not, in the ratio 99 : 1: where they
/// balance is the percentile. A single long wake-up counts for one step, however long; from nothing to 25 us takes 50
/// wake-ups that are too late, and back 5000 that are early.
class WakeMargin {
 public:
  /// Never more than `longest`; begins with `first`.
  explicit constexpr WakeMargin(std::chrono::nanoseconds longest, std::chrono::nanoseconds first = {}) noexcept
      : longest_(longest), margin_(first) {}

  /// A wake-up has taken so long, from the instant that was slept for until the thread ran.
  constexpr void observe(std::chrono::nanoseconds took) noexcept {
    margin_ = std::clamp(margin_ + (took > margin_ ? kUp : -kDown), std::chrono::nanoseconds{0}, longest_);
  }
  /// At present.
  [[nodiscard]] constexpr std::chrono::nanoseconds value() const noexcept { return margin_; }

 private:
  static constexpr std::chrono::nanoseconds kUp{495};
  static constexpr std::chrono::nanoseconds kDown{5};

  std::chrono::nanoseconds longest_;
  std::chrono::nanoseconds margin_;
};

}  // namespace driveline::rt
