#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/error/lock_cause.hpp"

namespace driveline::ecat_master::dc {

/// Decides from the phase errors whether a loop is locked: it is when the error has stayed inside a window for a while;
/// it no longer is when the error leaves four times that window, or after too long without a measurement. The error is
/// smoothed, because single ones are noisy: over some 16 measurements, and over more where they are noisier, 1,024 at
/// most, so that the mean itself varies by no more than a quarter of the window. \rtsafe throughout.
class LockDetector {
 public:
  /// When a loop counts as locked.
  struct Settings {
    double window_ns = 1250.0;         ///< greatest mean error, either way
    std::uint32_t lock_cycles = 200;   ///< inside the window in a row until locked
    std::uint32_t unlock_cycles = 50;  ///< outside four times the window in a row until lost
    std::uint32_t coast_cycles = 400;  ///< without a measurement until lost

    /// Settings for a cycle: a hundredth of the period as window; 100 ms, but 20 to 200 cycles, until locked; a quarter
    /// of that outside until lost, twice that without a measurement.
    [[nodiscard]] static Settings for_period(std::chrono::nanoseconds period) noexcept;
  };

  /// Starts unlocked, kAcquiring.
  explicit LockDetector(const Settings& settings) noexcept : settings_(settings) {}

  /// One cycle; nothing: no measurement. `noise_ns`: standard deviation of single measurements.
  void update(std::optional<double> error_ns, double noise_ns = 0.0) noexcept;
  /// The error has really jumped: restarts the mean at `error_ns`.
  void jump(double error_ns) noexcept { mean_error_ = error_ns; }
  /// Ends the lock for another reason.
  void lose(LockCause cause) noexcept;

  /// Whether the loop is locked, as of the last update().
  [[nodiscard]] bool locked() const noexcept { return cause_ == LockCause::kNone; }
  /// Why not; kNone while locked.
  [[nodiscard]] LockCause cause() const noexcept { return cause_; }
  /// Smoothed error in ns, positive: late.
  [[nodiscard]] double mean_error_ns() const noexcept { return mean_error_; }

 private:
  Settings settings_;
  double mean_error_ = 0.0;
  LockCause cause_ = LockCause::kAcquiring;
  std::uint32_t inside_ = 0;
  std::uint32_t outside_ = 0;
  std::uint32_t missing_ = 0;
};

}  // namespace driveline::ecat_master::dc
