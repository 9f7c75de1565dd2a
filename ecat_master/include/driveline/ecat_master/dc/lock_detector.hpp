#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/error/lock_cause.hpp"

namespace driveline::ecat_master::dc {

/// Decides from the phase errors whether a loop is locked: it locks when the error has stayed inside a window for some
/// time; it unlocks when the error leaves four times that window, or after too long without a measurement. The error is
/// smoothed, because single errors are noisy: over about 16 measurements, over more when they are noisier, at most
/// 1,024, so that the mean itself varies by no more than a quarter of the window. \rtsafe throughout.
class LockDetector {
 public:
  /// Limits for the lock state.
  struct Settings {
    double window_ns = 1250.0;         ///< largest magnitude of the mean error
    std::uint32_t lock_cycles = 200;   ///< consecutive cycles inside the window until locked
    std::uint32_t unlock_cycles = 50;  ///< consecutive cycles outside four times the window until unlocked
    std::uint32_t coast_cycles = 400;  ///< cycles without a measurement until unlocked

    /// Settings for a cycle: the window is a hundredth of the period; locked after 100 ms, limited to 20 to 200 cycles;
    /// unlocked after a quarter of that outside, or twice that without a measurement.
    [[nodiscard]] static Settings for_period(std::chrono::nanoseconds period) noexcept;
  };

  /// Starts unlocked with cause kAcquiring.
  explicit LockDetector(const Settings& settings) noexcept : settings_(settings) {}

  /// Processes one cycle; `error_ns` is empty without a measurement. `noise_ns`: standard deviation of single
  /// measurements.
  void update(std::optional<double> error_ns, double noise_ns = 0.0) noexcept;
  /// Restarts the mean at `error_ns` after a real jump of the error.
  void jump(double error_ns) noexcept { mean_error_ = error_ns; }
  /// Unlocks for another reason.
  void lose(LockCause cause) noexcept;

  /// Whether the loop is locked, as of the last update().
  [[nodiscard]] bool locked() const noexcept { return cause_ == LockCause::kNone; }
  /// Why the loop is not locked; kNone while locked.
  [[nodiscard]] LockCause cause() const noexcept { return cause_; }
  /// Smoothed error in ns; positive: late.
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
