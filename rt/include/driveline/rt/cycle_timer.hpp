#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/wake_margin.hpp"

namespace driveline::rt {

/// When a cycle was to begin, and when it did.
struct CycleStart {
  /// Number of the grid instant, counted from 0 at the first. Skipped periods are counted too, so that a setpoint
  /// taken at `cycle` belongs to `grid` whatever was missed.
  std::int64_t cycle;
  std::chrono::nanoseconds grid;  ///< the grid instant this cycle belongs to
  std::chrono::nanoseconds wake;  ///< when the thread was running, before `grid` only by CycleTimer's `early`
  std::int64_t missed;            ///< whole periods skipped just before this cycle

  /// The wake-up latency: from the first instant since the last cycle until the thread ran, skipped periods included;
  /// 0 for a thread that was early. wake - grid alone is that time modulo the period. `period` is that of the timer.
  /// \rtsafe
  [[nodiscard]] constexpr std::chrono::nanoseconds late(std::chrono::nanoseconds period) const noexcept {
    return std::max(wake - grid, std::chrono::nanoseconds{0}) + missed * period;
  }
};

/// Wakes a thread on a fixed grid of absolute times.
///
/// Late arrivals never move the grid: a thread that comes less than a period late starts at once, one that comes
/// later skips whole periods, which are counted, and continues on the grid. The phase moves only by shift_phase(),
/// the handle of a controller that follows another clock.
///
/// The thread cannot hog its CPU. Linux stops a SCHED_FIFO thread that uses more than 95 % of a second
/// (sched_rt_runtime_us) for tens of milliseconds; before it comes to that, the timer skips (and counts) a period and
/// sleeps: over time at most 16 of 17 parts are spent awake, spinning included.
///
/// Belongs to one thread. All functions but the constructor are \rtsafe.
class CycleTimer {
 public:
  /// Longest useful spin lead: a quarter of the period, the rest remains for sleeping.
  [[nodiscard]] static constexpr std::chrono::nanoseconds max_wake_ahead(std::chrono::nanoseconds period) noexcept {
    return period / 4;
  }

  /// A grid of `period` (> 0) on `clock`, which must outlive the timer. `wake_ahead` (0 .. max_wake_ahead) is how long
  /// before the grid instant to wake and spin: an idle virtual CPU needs 15 to 25 us to wake, a spinning one none.
  /// None: as long as wake-ups turn out to take (WakeMargin), on a clock whose sleeps end in time not at all. The grid
  /// starts now until start() says otherwise.
  /// `early` (0 .. max_wake_ahead): the thread is to run that long before the grid instant, as one whose frames are
  /// held back until then; `wake_ahead` is before that.
  /// @throws std::invalid_argument if a value is out of range.
  CycleTimer(Clock& clock, std::chrono::nanoseconds period,
             std::optional<std::chrono::nanoseconds> wake_ahead = std::chrono::nanoseconds{0},
             std::chrono::nanoseconds early = std::chrono::nanoseconds{0});

  /// Puts instant 0 of the grid at `first` (usually a little ahead) and forgets shifts and counters.
  void start(std::chrono::nanoseconds first) noexcept;

  /// Sleeps to the next grid instant, less `early`. Returns at once if it has passed less than a period ago; see the
  /// class.
  CycleStart wait_next() noexcept;

  /// The sleep of the next wait_next(), which spins then from where this returns: wake_ahead() before the grid instant
  /// at best, so that what can be done before it is done in time that is spent anyway.
  void sleep_ahead() noexcept;

  /// Moves the next grid instant, and all that follow, by `shift` (positive: later). The sum of the shifts before one
  /// wait_next() is limited to half a period either way; the excess is dropped, because a controller that is still off
  /// in the next cycle shifts again.
  /// @return the part of `shift` that was accepted.
  std::chrono::nanoseconds shift_phase(std::chrono::nanoseconds shift) noexcept;

  /// Distance of two instants of the grid. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds period() const noexcept { return period_; }
  /// Sum of all accepted shifts since start().
  [[nodiscard]] std::chrono::nanoseconds phase_shift() const noexcept { return phase_shift_; }
  /// How long before the grid instant it wakes now.
  [[nodiscard]] std::chrono::nanoseconds wake_ahead() const noexcept { return wake_ahead_.value_or(margin_.value()); }
  /// Periods skipped since start().
  [[nodiscard]] std::int64_t missed_total() const noexcept { return missed_total_; }
  /// How often since start() the sleep had to be lengthened to leave the CPU its share.
  [[nodiscard]] std::int64_t forced_rests() const noexcept { return forced_rests_; }

 private:
  void sleep_towards_next() noexcept;
  void owe_rest(std::chrono::nanoseconds awake) noexcept;
  [[nodiscard]] std::chrono::nanoseconds next_at_or_after(std::chrono::nanoseconds time) const noexcept;

  Clock& clock_;
  std::chrono::nanoseconds period_;
  std::chrono::nanoseconds early_;
  std::optional<std::chrono::nanoseconds> wake_ahead_;  // none: margin_
  WakeMargin margin_;
  std::chrono::nanoseconds next_{};           // the next grid instant
  std::chrono::nanoseconds pending_shift_{};  // accepted, taken over by the next sleep
  std::chrono::nanoseconds phase_shift_{};
  std::chrono::nanoseconds awake_since_{};
  std::chrono::nanoseconds rest_debt_{};       // sleep still owed for the time awake
  std::chrono::nanoseconds awake_unproven_{};  // time awake since cpu_at_ was read
  std::chrono::nanoseconds cpu_at_{};          // CPU time of the thread then
  bool slept_ = false;                         // sleep_ahead() has slept for the next wait_next()
  std::int64_t next_cycle_ = 0;
  std::int64_t missed_total_ = 0;
  std::int64_t forced_rests_ = 0;
};

}  // namespace driveline::rt
