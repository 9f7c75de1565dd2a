#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/dc/lock_detector.hpp"

namespace driveline::ecat_master::dc {

/// Holds the phase of a cycle against the reference clock: a proportional-integral controller, fed once per cycle with
/// how late the cycle's frame met the reference clock, which answers by how much to move the next grid instant.
///
/// The plant: an error of e(k) with a reference clock that runs d too fast becomes e(k+1) = e(k) + d * period + shift.
/// With shift = -(kp * e + i), i += ki * e, kp = 2w and ki = w^2 the loop is critically damped: both poles at 1 - w,
/// a disturbance decays to 1 % within about 7 / w cycles. w, in rad per cycle, is 2 pi * 5 Hz * period, at least 0.01
/// and at most 0.25, as long as measurements are good:
///
///   | period | w     | kp    | ki     | 1 % after |
///   |--------|-------|-------|--------|-----------|
///   | 125 us | 0.010 | 0.020 | 0.0001 |  83 ms    |
///   | 250 us | 0.010 | 0.020 | 0.0001 | 166 ms    |
///   | 1 ms   | 0.031 | 0.063 | 0.0010 | 211 ms    |
///   | 4 ms   | 0.126 | 0.251 | 0.0158 | 211 ms    |
///   | 10 ms  | 0.250 | 0.500 | 0.0625 | 242 ms    |
///
/// The lower limit keeps the loop faster than the thermal drift of oscillators at every period, the upper one keeps it
/// from following the noise of single measurements.
///
/// Where frames leave, pass or are taken unevenly, measurements are noisy, and the loop is slower by as much: 1.5 w of
/// the power of the noise gets into the grid, of which it is to be no more than a 400th of the period. The noise is
/// what measurements differ from what was expected of them; nobody has to know it. w falls to 0.001 at the least, and
/// no lower than that a disturbance decays to 1 % within a second: 1 ppm/s of thermal drift is 16 ns at 125 us then.
///
/// - A measurement far from what was expected, and from what is usual here, is an outlier and is not followed; when it
///   persists, it is followed.
/// - Without a measurement the grid coasts on the frequency learned so far.
/// - Locked is who has stayed inside the lock window for a while; lost is the lock only outside a wider window, or
///   after coasting for too long.
/// - The frequency is limited to +-500 ppm: a clock further off than that is none that a servo line should follow.
///
/// No I/O, no allocation; every function is \rtsafe.
class PhaseController {
 public:
  /// Times are those of the grid's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Greatest frequency difference that is followed, either way.
  static constexpr double kMaxPpm = kMaxFrequencyPpm;

  /// How the loop is tuned.
  struct Settings {
    Nanoseconds period = std::chrono::microseconds{125};  ///< 125 us to 10 ms
    double bandwidth_hz = 5.0;                            ///< of the closed loop; see the table above
    /// Deviation from the expected error that makes a measurement suspicious, at least; 0: a hundredth of the period.
    /// Above that, eight times the mean deviation counts.
    Nanoseconds outlier_floor{0};
    std::uint32_t outliers_believed = 8;  ///< suspicious measurements in a row until they are followed
  };

  /// Why the controller is not locked.
  using Cause = LockCause;

  /// Starts as after reset().
  explicit PhaseController(const Settings& settings) noexcept;

  /// Starts anew; `ppm`: known frequency difference, positive: the reference clock is faster; 0 when unknown.
  void reset(double ppm = 0.0) noexcept;

  /// One cycle. `error`: how much later than wanted the frame met the reference clock (of a frame sent exactly at the
  /// grid instant; see SystemTime), nothing when it did not come back. Returns by how much the next grid instant is to
  /// be moved, positive: later.
  [[nodiscard]] Nanoseconds update(std::optional<Nanoseconds> error) noexcept;

  /// As of the last update(), see LockDetector.
  [[nodiscard]] bool locked() const noexcept { return lock_.locked(); }
  /// Why not; kNone while locked.
  [[nodiscard]] Cause cause() const noexcept { return lock_.cause(); }
  /// How much the reference clock runs faster than the clock of the grid, in parts per million.
  [[nodiscard]] double ppm() const noexcept { return integral_ / period_ns_ * 1e6; }
  /// The error, smoothed over some 16 measurements.
  [[nodiscard]] double mean_error_ns() const noexcept { return lock_.mean_error_ns(); }
  /// Measurements that were not followed.
  [[nodiscard]] std::uint64_t outliers() const noexcept { return outliers_; }
  /// Cycles without a measurement.
  [[nodiscard]] std::uint64_t coasted() const noexcept { return coasted_; }
  /// Standard deviation of single measurements, were they independent and normally distributed.
  [[nodiscard]] double noise_ns() const noexcept { return kNoisePerSpread * spread_; }
  /// kp as defined above, for this period, bandwidth and noise.
  [[nodiscard]] double proportional_gain() const noexcept { return kp_; }
  /// ki as defined above.
  [[nodiscard]] double integral_gain() const noexcept { return ki_; }

 private:
  /// The difference of two normally distributed values is sqrt(2) * 0.798 of their deviation on average.
  static constexpr double kNoisePerSpread = 0.886;

  [[nodiscard]] bool plausible(double error) noexcept;
  void choose_gains() noexcept;
  [[nodiscard]] double control(double error) noexcept;
  [[nodiscard]] Nanoseconds quantize(double shift) noexcept;

  Settings settings_;
  double period_ns_;
  double widest_;     ///< bandwidth w while there is no noise
  double narrowest_;  ///< whatever the noise
  double kp_ = 0.0;
  double ki_ = 0.0;
  double outlier_floor_;
  LockDetector lock_;

  double integral_ = 0.0;   ///< of the reference clock, per period, in ns
  double expected_ = 0.0;   ///< predicted next error
  double spread_ = 0.0;     ///< mean deviation from it
  double remainder_ = 0.0;  ///< of the shifts, below one nanosecond
  bool primed_ = false;     ///< expected_ is valid
  std::uint32_t suspicious_ = 0;
  std::uint32_t at_limit_ = 0;
  std::uint64_t outliers_ = 0;
  std::uint64_t coasted_ = 0;
};

}  // namespace driveline::ecat_master::dc
