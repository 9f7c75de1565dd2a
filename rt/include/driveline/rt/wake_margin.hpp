#pragma once

#include <algorithm>
#include <chrono>

namespace driveline::rt {

/// How long before an instant a thread must wake in order to run at that instant. Adapts to the measured wake-up times
/// of this thread on this machine, so that 99 of 100 wake-ups are in time. Belongs to one thread. \rtsafe
///
/// The margin takes a large step up for each wake-up that took longer, and a small step down for each that did not, in
/// the ratio 99 : 1, so that it settles at the 99th percentile. A single long wake-up counts as one step, however long
/// it was; from 0 to 25 us takes 50 late wake-ups, and back 5000 early ones.
class WakeMargin {
 public:
  /// The margin never exceeds `longest`; it starts with `first`.
  explicit constexpr WakeMargin(std::chrono::nanoseconds longest, std::chrono::nanoseconds first = {}) noexcept
      : longest_(longest), margin_(first) {}

  /// Reports that a wake-up took `took`, from the end of the requested sleep until the thread ran.
  constexpr void observe(std::chrono::nanoseconds took) noexcept {
    margin_ = std::clamp(margin_ + (took > margin_ ? kUp : -kDown), std::chrono::nanoseconds{0}, longest_);
  }
  /// Current margin.
  [[nodiscard]] constexpr std::chrono::nanoseconds value() const noexcept { return margin_; }

 private:
  static constexpr std::chrono::nanoseconds kUp{495};
  static constexpr std::chrono::nanoseconds kDown{5};

  std::chrono::nanoseconds longest_;
  std::chrono::nanoseconds margin_;
};

}  // namespace driveline::rt
