#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Time control loop of a slave controller: speeds up or slows down the local time so that the local copy of the system
/// time follows the reference clock (ESC data sheet I, distributed clocks, drift compensation).
///
/// Like the hardware, it adds or omits single nanoseconds; the speed counters determine how many: speed counter
/// difference D at speed counter start S changes the rate by D / (5 (S + D + 2) (S - D + 2)) (ESC data sheet II,
/// 0x0932). How D depends on the measured differences is not published; this loop uses a proportional and an integral
/// part, critically damped. Its time constant at the reset values is 50 ms, or 400 reference times if their interval is
/// shorter than 125 us; several reference times in a frame count separately. Differences above some microseconds are
/// first corrected at maximum speed, without overshoot. A larger S or filter depth slows the loop down.
///
/// Counts are in nanoseconds of the slave's oscillator. \rtsafe throughout.
class TimeLoop {
 public:
  /// Registers 0x0930 and 0x0935.
  struct Settings {
    std::uint16_t speed_counter_start = 0x1000;  ///< 0x0930: larger is slower
    std::uint8_t filter_depth = 12;              ///< 0x0935: exponent of the filter of the mean difference
  };

  /// Resets to power-on: local time `start` at count 0, uncorrected.
  void reset(std::int64_t start) noexcept;
  /// Returns the local time at a count; a 64-bit number that wraps around like the controller's.
  [[nodiscard]] std::uint64_t local(std::int64_t count) const noexcept;
  /// Limit of count_of(), 2.3 years.
  static constexpr std::int64_t kReach = std::int64_t{1} << 56;
  /// Returns the first count where the local time is not before `local`; nullopt when that is more than kReach away
  /// from the last reference time, or from power-on if there was none.
  [[nodiscard]] std::optional<std::int64_t> count_of(std::uint64_t local) const noexcept;

  /// Corrects the rate after the local copy was found `difference` ns ahead of the reference at `count`.
  void follow(std::int64_t difference, std::int64_t count, const Settings& settings) noexcept;
  /// Called after a write to 0x0930: resets the rate to that of the oscillator.
  void restart(std::int64_t count) noexcept;
  /// Returns 0x0932: positive when the local clock is too slow and is sped up.
  [[nodiscard]] std::int16_t speed_counter_difference() const noexcept { return difference_; }

 private:
  struct Speed {
    double rate;  ///< relative, added to the oscillator's rate
    int counter;
  };
  [[nodiscard]] static Speed quantised(double rate, const Settings& settings) noexcept;
  void anchor(std::int64_t count) noexcept;
  [[nodiscard]] double gained(std::int64_t distance) const noexcept;

  // Local time is piecewise linear in the count: it starts at the anchor, with `rate_` for `hold_` counts, then with
  // `settled_rate_`.
  std::int64_t anchor_count_ = 0;
  std::uint64_t anchor_local_ = 0;
  double anchor_fraction_ = 0.0;
  double rate_ = 0.0;
  double settled_rate_ = 0.0;
  std::int64_t hold_ = 0;

  double integral_ = 0.0;  ///< relative rate
  std::int16_t difference_ = 0;
  std::optional<std::int64_t> last_;  ///< count of the last reference time
  std::int64_t period_ = 0;           ///< interval between the last two reference times
  int repeats_ = 0;                   ///< reference times at the count last_
  double settled_integral_ = 0.0;     ///< integral_ before the reference times at last_
};

}  // namespace driveline::slaves
