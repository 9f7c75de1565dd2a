#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace driveline::slaves::msd {

/// Control cycle (MSD manual Table 10.8).
inline constexpr std::chrono::nanoseconds kControlStep{62'500};
/// Step in which inputs and outputs of the bus change (MSD manual 9.1).
inline constexpr std::chrono::nanoseconds kProcessDataPeriod{125'000};
inline constexpr double kControlStepS = 62.5e-6;  ///< kControlStep in s

/// Time of the drive: the number of control cycles so far, and the end of the current one on the clock of advance().
class ControlClock {
 public:
  /// Starts the first cycle. \rtsafe
  void start(std::chrono::nanoseconds now) noexcept { end_ = now + kControlStep; }
  /// Whether start() has been called. \rtsafe
  [[nodiscard]] bool started() const noexcept { return end_.has_value(); }
  /// Returns the end of the current cycle. Precondition: started(). \rtsafe
  [[nodiscard]] std::chrono::nanoseconds cycle_end() const noexcept { return *end_; }
  /// Moves the end of the current cycle to `end`; no effect before start(). \rtsafe
  void align(std::chrono::nanoseconds end) noexcept {
    if (end_) end_ = end;
  }
  /// Skips whole cycles, so that at most `most` remains to be run. \rtsafe
  void limit_backlog(std::chrono::nanoseconds now, std::chrono::nanoseconds most) noexcept {
    if (now - *end_ > most) *end_ += (now - *end_ - most) / kControlStep * kControlStep;
  }
  /// Proceeds to the next cycle. \rtsafe
  void count() noexcept {
    ++steps_;
    *end_ += kControlStep;
  }

  /// Returns the number of complete cycles. \rtsafe
  [[nodiscard]] std::uint64_t cycles() const noexcept { return steps_; }
  /// Returns the duration of all complete cycles. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds running_time() const noexcept {
    return static_cast<std::int64_t>(steps_) * kControlStep;
  }
  /// Whether process data are handled in this cycle. \rtsafe
  [[nodiscard]] bool process_data_cycle() const noexcept { return steps_ % 2 == 0; }
  /// Whether this is the first cycle of a millisecond. \rtsafe
  [[nodiscard]] bool millisecond() const noexcept { return steps_ % kStepsPerMs == 0; }

 private:
  static constexpr std::uint64_t kStepsPerMs = 16;
  std::optional<std::chrono::nanoseconds> end_;
  std::uint64_t steps_ = 0;
};

}  // namespace driveline::slaves::msd
