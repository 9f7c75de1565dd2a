#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/esc/clock_options.hpp"

namespace driveline::slaves {

/// The oscillator of an emulated slave: counts nanoseconds from power-on with a rate error, in steps of its period.
/// Times in parameters and results are true times on the line's clock. \rtsafe throughout.
class Oscillator {
 public:
  /// True times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Takes rate error, wander, period and seed from `options`; counts from time 0 until power_on().
  explicit Oscillator(const ClockOptions& options) noexcept;

  /// Starts counting from 0 at `now`.
  void power_on(Nanoseconds now) noexcept { origin_ = now; }
  /// Returns the count at a true time: that of the last step, a multiple of the period.
  [[nodiscard]] std::int64_t count(Nanoseconds now) const noexcept;
  /// Limit of counts in both directions, 36 years.
  static constexpr std::int64_t kReach = std::int64_t{1} << 60;
  /// Returns the true time of the first step whose count is at least `count`, rounded up to whole nanoseconds.
  [[nodiscard]] Nanoseconds time_of(std::int64_t count) const noexcept;
  /// Returns the error of the rate at a true time, in ppm; for tests.
  [[nodiscard]] double rate_error_ppm(Nanoseconds now) const noexcept;

 private:
  [[nodiscard]] std::int64_t elapsed_count(std::int64_t elapsed) const noexcept;
  [[nodiscard]] double wander_ns(double elapsed) const noexcept;

  std::int64_t period_ = 1;
  double drift_ = 0.0;          ///< relative rate error
  double span_ = 0.0;           ///< relative rate error by temperature, amplitude
  double wander_period_ = 0.0;  ///< ns; 0: none
  double wander_phase_ = 0.0;   ///< share of the period
  Nanoseconds origin_{0};
};

}  // namespace driveline::slaves
