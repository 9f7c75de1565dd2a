#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/dc/lock_detector.hpp"

namespace driveline::ecat_master::dc {

/// Holds the phase of a cycle relative to the reference clock: a proportional-integral controller that takes, once per
/// cycle, the delay with which the cycle's frame met the reference clock, and returns the shift of the next grid
/// instant.
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
/// The lower limit keeps the loop faster than the thermal drift of oscillators at every period; the upper limit keeps
/// it from following the noise of single measurements.
///
/// When frames leave, pass or are received unevenly, measurements are noisy, and the loop gets slower accordingly: 1.5
/// w of the noise power reaches the grid, and must not exceed a 400th of the period. The noise is estimated from the
/// differences between measured and expected errors; it need not be configured. w falls at most to 0.001, and never so
/// low that a disturbance takes longer than a second to decay to 1 %: 1 ppm/s of thermal drift then causes 16 ns at 125
/// us.
///
/// - A measurement far from the expected error, compared with the usual deviation, is an outlier and is ignored; when
///   outliers persist, they are followed.
/// - Without a measurement the grid coasts at the frequency learned so far.
/// - The loop locks after some time inside the lock window; it unlocks only outside a wider window, or after coasting
///   for too long.
/// - The frequency is limited to +-500 ppm: a servo line should not follow a clock with a larger deviation.
///
/// No I/O, no allocation; every function is \rtsafe.
class PhaseController {
 public:
  /// Times on the grid's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Largest magnitude of the frequency difference that is followed, in ppm.
  static constexpr double kMaxPpm = kMaxFrequencyPpm;

  /// Tuning of the loop.
  struct Settings {
    Nanoseconds period = std::chrono::microseconds{125};  ///< 125 us to 10 ms
    double bandwidth_hz = 5.0;                            ///< bandwidth of the closed loop; see the table above
    /// Smallest deviation from the expected error that makes a measurement suspicious; 0: a hundredth of the period.
    /// The threshold is larger when eight times the mean deviation is.
    Nanoseconds outlier_floor{0};
    std::uint32_t outlier_limit = 8;  ///< consecutive suspicious measurements after which they are followed
  };

  /// Why the controller is not locked.
  using Cause = LockCause;

  /// Starts in the state after reset().
  explicit PhaseController(const Settings& settings) noexcept;

  /// Restarts the controller; `ppm`: known frequency difference, positive: the reference clock is faster; 0 when
  /// unknown.
  void reset(double ppm = 0.0) noexcept;

  /// Processes one cycle. `error`: how much later than wanted the frame met the reference clock (converted to a frame
  /// sent exactly at the grid instant; see SystemTime); empty when the frame did not return. Returns the shift of the
  /// next grid instant, positive: later.
  [[nodiscard]] Nanoseconds update(std::optional<Nanoseconds> error) noexcept;

  /// Whether the loop is locked as of the last update(), see LockDetector.
  [[nodiscard]] bool locked() const noexcept { return lock_.locked(); }
  /// Why it is not locked; kNone while locked.
  [[nodiscard]] Cause cause() const noexcept { return lock_.cause(); }
  /// Frequency of the reference clock relative to the clock of the grid, in ppm; positive: the reference clock is
  /// faster.
  [[nodiscard]] double ppm() const noexcept { return integral_ / period_ns_ * 1e6; }
  /// The error in ns, smoothed over about 16 measurements.
  [[nodiscard]] double mean_error_ns() const noexcept { return lock_.mean_error_ns(); }
  /// Number of measurements that were ignored.
  [[nodiscard]] std::uint64_t outliers() const noexcept { return outliers_; }
  /// Number of cycles without a measurement.
  [[nodiscard]] std::uint64_t coasted() const noexcept { return coasted_; }
  /// Standard deviation of single measurements in ns, assuming independent, normally distributed errors.
  [[nodiscard]] double noise_ns() const noexcept { return kNoisePerSpread * spread_; }
  /// kp as defined above, for this period, bandwidth and noise.
  [[nodiscard]] double proportional_gain() const noexcept { return kp_; }
  /// ki as defined above.
  [[nodiscard]] double integral_gain() const noexcept { return ki_; }

 private:
  /// The difference of two normally distributed values averages sqrt(2) * 0.798 of their standard deviation.
  static constexpr double kNoisePerSpread = 0.886;

  [[nodiscard]] bool plausible(double error) noexcept;
  void choose_gains() noexcept;
  [[nodiscard]] double control(double error) noexcept;
  [[nodiscard]] Nanoseconds quantize(double shift) noexcept;

  Settings settings_;
  double period_ns_;
  double widest_;     ///< bandwidth w without noise
  double narrowest_;  ///< smallest w at any noise
  double kp_ = 0.0;
  double ki_ = 0.0;
  double outlier_floor_;
  LockDetector lock_;

  double integral_ = 0.0;   ///< advance of the reference clock per period, in ns
  double expected_ = 0.0;   ///< predicted next error, in ns
  double spread_ = 0.0;     ///< mean deviation from the prediction, in ns
  double remainder_ = 0.0;  ///< part of the shifts below one nanosecond
  bool primed_ = false;     ///< expected_ is valid
  std::uint32_t suspicious_ = 0;
  std::uint32_t at_limit_ = 0;
  std::uint64_t outliers_ = 0;
  std::uint64_t coasted_ = 0;
};

}  // namespace driveline::ecat_master::dc
