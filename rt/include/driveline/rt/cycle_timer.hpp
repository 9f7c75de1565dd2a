#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/wake_margin.hpp"

namespace driveline::rt {

/// Scheduled and actual start of a cycle.
struct CycleStart {
  /// Number of the grid instant, counted from 0. Skipped periods are counted too, so that a setpoint computed for
  /// `cycle` always belongs to `grid`, regardless of missed periods.
  std::int64_t cycle;
  std::chrono::nanoseconds grid;  ///< grid instant of this cycle
  std::chrono::nanoseconds wake;  ///< time at which the thread ran; before `grid` only with CycleTimer's `early`
  std::int64_t missed;            ///< whole periods skipped just before this cycle

  /// Wake-up latency: from the first grid instant after the previous cycle until the thread ran, skipped periods
  /// included; 0 for a thread that was early. (wake - grid alone is that time modulo the period.) `period` is the
  /// period of the timer. \rtsafe
  [[nodiscard]] constexpr std::chrono::nanoseconds late(std::chrono::nanoseconds period) const noexcept {
    return std::max(wake - grid, std::chrono::nanoseconds{0}) + missed * period;
  }
};

/// Wakes a thread on a fixed grid of absolute times.
///
/// Late arrivals never move the grid: a thread that is less than a period late starts at once; a thread that is later
/// skips whole periods, which are counted, and continues on the grid. Only shift_phase() moves the phase; a controller
/// that follows another clock calls it.
///
/// The thread cannot monopolise its CPU. Linux stops a SCHED_FIFO thread that uses more than 95 % of a second
/// (sched_rt_runtime_us) for tens of milliseconds. Before that happens the timer skips (and counts) a period and
/// sleeps: over time the thread is awake for at most 16 of 17 parts, spinning included.
///
/// Belongs to one thread. All functions except the constructor are \rtsafe.
class CycleTimer {
 public:
  /// Longest useful spin lead: a quarter of the period; the rest remains for sleeping.
  [[nodiscard]] static constexpr std::chrono::nanoseconds max_wake_ahead(std::chrono::nanoseconds period) noexcept {
    return period / 4;
  }

  /// Creates a grid of `period` (> 0) on `clock`, which must outlive the timer. The grid starts now; start() moves it.
  /// `wake_ahead` (0 .. max_wake_ahead) is how long before the grid instant the thread wakes and starts to spin: an
  /// idle virtual CPU needs 15 to 25 us to wake, a spinning CPU none. nullopt: adapt to the measured wake-up times
  /// (WakeMargin), which gives 0 on a clock whose sleeps end on time.
  /// `early` (0 .. max_wake_ahead) is how long before the grid instant the thread must run, for a thread whose frames
  /// are held back until that instant; `wake_ahead` is added to it.
  /// @throws std::invalid_argument if a value is out of range.
  CycleTimer(Clock& clock, std::chrono::nanoseconds period,
             std::optional<std::chrono::nanoseconds> wake_ahead = std::chrono::nanoseconds{0},
             std::chrono::nanoseconds early = std::chrono::nanoseconds{0});

  /// Puts instant 0 of the grid at `first` (usually slightly in the future) and resets shifts and counters.
  void start(std::chrono::nanoseconds first) noexcept;

  /// Sleeps until `early` before the next grid instant. Returns at once if that instant passed less than a period ago;
  /// see the class.
  CycleStart wait_next() noexcept;

  /// Performs the sleep part of the next wait_next(), which then only spins. Returns wake_ahead() before the grid
  /// instant at best, so that the caller can use the time that would otherwise be spent spinning.
  void sleep_ahead() noexcept;

  /// Moves the next grid instant, and all following ones, by `shift` (positive: later). The sum of the shifts before
  /// one wait_next() is limited to half a period in either direction; the excess is dropped, because a controller that
  /// is still off in the next cycle shifts again.
  /// @return the part of `shift` that was accepted.
  std::chrono::nanoseconds shift_phase(std::chrono::nanoseconds shift) noexcept;

  /// Distance between two grid instants. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds period() const noexcept { return period_; }
  /// Sum of all accepted shifts since start().
  [[nodiscard]] std::chrono::nanoseconds phase_shift() const noexcept { return phase_shift_; }
  /// Current lead of the wake-up before the grid instant.
  [[nodiscard]] std::chrono::nanoseconds wake_ahead() const noexcept { return wake_ahead_.value_or(margin_.value()); }
  /// Periods skipped since start().
  [[nodiscard]] std::int64_t missed_total() const noexcept { return missed_total_; }
  /// Number of sleeps since start() that were lengthened to limit the thread's share of the CPU.
  [[nodiscard]] std::int64_t forced_rests() const noexcept { return forced_rests_; }

 private:
  void sleep_towards_next() noexcept;
  void owe_rest(std::chrono::nanoseconds awake) noexcept;
  [[nodiscard]] std::chrono::nanoseconds next_at_or_after(std::chrono::nanoseconds time) const noexcept;

  Clock& clock_;
  std::chrono::nanoseconds period_;
  std::chrono::nanoseconds early_;
  std::optional<std::chrono::nanoseconds> wake_ahead_;  // nullopt: use margin_
  WakeMargin margin_;
  std::chrono::nanoseconds next_{};           // next grid instant
  std::chrono::nanoseconds pending_shift_{};  // accepted; applied by the next sleep
  std::chrono::nanoseconds phase_shift_{};
  std::chrono::nanoseconds awake_since_{};
  std::chrono::nanoseconds rest_debt_{};       // sleep still owed for time spent awake
  std::chrono::nanoseconds awake_unproven_{};  // time awake since cpu_at_ was read
  std::chrono::nanoseconds cpu_at_{};          // CPU time of the thread at the last reading
  bool slept_ = false;                         // sleep_ahead() has already slept for the next wait_next()
  std::int64_t next_cycle_ = 0;
  std::int64_t missed_total_ = 0;
  std::int64_t forced_rests_ = 0;
};

}  // namespace driveline::rt
