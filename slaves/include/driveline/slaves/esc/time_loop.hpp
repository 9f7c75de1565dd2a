#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Time control loop of a slave controller: speeds the local time up or slows it down so that the local copy of the
/// system time follows the reference clock (ESC data sheet I, distributed clocks, drift compensation).
///
/// Like the hardware it adds or leaves out single nanoseconds, as many as the speed counters say: speed counter
/// difference D at speed counter start S changes the rate by D / (5 (S + D + 2) (S - D + 2)) (ESC data sheet II,
/// 0x0932). How D follows from the differences is not published; here a proportional share and an integral,
/// critically damped. Its time constant at the reset values is 50 ms, or 400 reference times if these come faster than
/// every 125 us; several in one frame count each. Differences above some microseconds are made up for at full speed
/// first, without overshoot. A larger S or filter depth makes it slower.
///
/// Counts are those of the oscillator, in nanoseconds of its own. \rtsafe throughout.
class TimeLoop {
 public:
  /// Registers 0x0930 and 0x0935.
  struct Settings {
    std::uint16_t speed_counter_start = 0x1000;  ///< 0x0930: larger is slower
    std::uint8_t filter_depth = 12;              ///< 0x0935: exponent of the filter of the differences' mean
  };

  /// Power-on: local time `start` at count 0, uncorrected.
  void reset(std::int64_t start) noexcept;
  /// Local time at a count; a number of 64 bits that begins again at 0, as the controller's does.
  [[nodiscard]] std::uint64_t local(std::int64_t count) const noexcept;
  /// Limit of count_of(), 2.3 years.
  static constexpr std::int64_t kReach = std::int64_t{1} << 56;
  /// First count at which the local time is not before `local`; nothing when that is more than kReach away from the
  /// last reference time, or from power-on without any.
  [[nodiscard]] std::optional<std::int64_t> count_of(std::uint64_t local) const noexcept;

  /// At `count` the local copy was found `difference` ns ahead of the reference.
  void follow(std::int64_t difference, std::int64_t count, const Settings& settings) noexcept;
  /// 0x0930 was written: the speed is that of the oscillator again.
  void restart(std::int64_t count) noexcept;
  /// 0x0932: positive when the local clock is too slow and is sped up.
  [[nodiscard]] std::int16_t speed_counter_difference() const noexcept { return difference_; }

 private:
  struct Speed {
    double rate;  ///< relative, in addition to the oscillator's
    int counter;
  };
  [[nodiscard]] static Speed quantised(double rate, const Settings& settings) noexcept;
  void anchor(std::int64_t count) noexcept;
  [[nodiscard]] double gained(std::int64_t distance) const noexcept;

  // Local time is piecewise linear in the count: this from the anchor on, `rate_` up to `hold_` counts behind it,
  // `settled_rate_` from there on.
  std::int64_t anchor_count_ = 0;
  std::uint64_t anchor_local_ = 0;
  double anchor_fraction_ = 0.0;
  double rate_ = 0.0;
  double settled_rate_ = 0.0;
  std::int64_t hold_ = 0;

  double integral_ = 0.0;  ///< relative rate
  std::int16_t difference_ = 0;
  std::optional<std::int64_t> last_;  ///< count when a reference time came last
  std::int64_t period_ = 0;           ///< between that and the one before
  int repeats_ = 0;                   ///< reference times at that count
  double settled_integral_ = 0.0;     ///< before them
};

}  // namespace driveline::slaves
