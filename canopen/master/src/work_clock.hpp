#pragma once

#include <chrono>

#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

/// A clock that stands still between the two parts of the work of a period, for the figures of motion::CycleRecord:
/// SYNC and outputs at the grid instant, and the answers before the next one. \rtsafe
class WorkClock final : public rt::Clock {
 public:
  /// The clock must outlive this.
  explicit WorkClock(rt::Clock& clock) noexcept : clock_(clock) {}

  /// Shows the time of the clock, less `spent`.
  void restart(std::chrono::nanoseconds spent) noexcept { stood_ = spent; }
  /// Stands still until go_on().
  void pause() noexcept { paused_at_ = clock_.now(); }
  /// Goes on from the time at which it stands.
  void go_on() noexcept { stood_ += clock_.now() - paused_at_; }

  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_.now() - stood_; }
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override { clock_.sleep_until(deadline + stood_); }
  void spin() noexcept override { clock_.spin(); }

 private:
  rt::Clock& clock_;
  std::chrono::nanoseconds stood_{0};
  std::chrono::nanoseconds paused_at_{0};
};

}  // namespace driveline::canopen
