#pragma once

#include <chrono>

#include "driveline/slaves/can/node.hpp"

namespace driveline::slaves::msd {

/// Monitors SYNC or RxPDOs in Operational (P 2061, P 2062; MSD manual 8.5), from the first one on. \rtsafe throughout.
class TelegramWatch {
 public:
  /// The signals that can be monitored, numbered as in P 2061.
  enum class Signal : std::uint8_t { kSync = 0, kRxPdo = 1 };

  /// Selects the signal and the time after it that is a failure; 0: none. Waits for a first signal.
  void configure(Signal signal, std::chrono::milliseconds time_out) noexcept;
  /// Waits for a first signal: the drive has entered or left Operational.
  void restart(bool operational) noexcept;
  /// A signal has come.
  void came(Signal signal, std::chrono::nanoseconds now) noexcept;
  /// Returns whether the signal has just failed.
  [[nodiscard]] bool fails(std::chrono::nanoseconds now) noexcept;
  /// When fails() can be true; can::kNever for never.
  [[nodiscard]] std::chrono::nanoseconds deadline() const noexcept { return deadline_; }
  /// Whether the signal has failed and has not come since.
  [[nodiscard]] bool lost() const noexcept { return lost_; }

 private:
  Signal signal_ = Signal::kSync;
  std::chrono::milliseconds time_out_{0};
  std::chrono::nanoseconds deadline_ = can::kNever;
  bool operational_ = false;
  bool lost_ = false;
};

}  // namespace driveline::slaves::msd
