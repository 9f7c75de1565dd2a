#pragma once

#include <atomic>
#include <chrono>

namespace driveline::rt {

/// Source of time for all components. It is passed in, never global, so that a whole line (master, drives, clocks) can
/// run on a clock that a test advances by hand.
///
/// Times are nanoseconds since the clock's own epoch. All functions are \rtsafe.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Returns the current time, which never runs backwards.
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;

  /// Sleeps until `deadline` or later; returns at once if it has passed.
  virtual void sleep_until(std::chrono::nanoseconds deadline) noexcept = 0;

  /// Executes one iteration of a busy-wait loop: a CPU pause on the real clock, a small step forward on the virtual
  /// clock (so that a loop that spins up to a deadline ends).
  virtual void spin() noexcept = 0;

  /// Spins until `instant`; returns at once if it has passed. @return the time of the last clock reading, `instant` or
  /// later.
  virtual std::chrono::nanoseconds spin_until(std::chrono::nanoseconds instant) noexcept {
    auto time = now();
    for (; time < instant; time = now()) spin();
    return time;
  }

  /// Executes one iteration of a busy-wait loop that waits for another thread, which may need this same CPU: ready
  /// real-time threads of the same priority run first. Costs two system calls on the real clock, so do not call it in
  /// every iteration.
  virtual void yield() noexcept { spin(); }

  /// CPU time that the calling thread has used, since an arbitrary instant. By default all time counts as used: no
  /// other thread competes on a clock that is advanced by hand. A system call on the real clock, so do not call it in
  /// every cycle.
  [[nodiscard]] virtual std::chrono::nanoseconds cpu_time() const noexcept { return now(); }
};

/// CLOCK_MONOTONIC. Any number of threads may share one object.
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override;
  /// Sleeps until the absolute time `deadline`; signal handlers that run meanwhile do not shorten the sleep.
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  void spin() noexcept override;
  std::chrono::nanoseconds spin_until(std::chrono::nanoseconds instant) noexcept override;
  /// Calls sched_yield(2) if the thread is a real-time thread; the kernel preempts threads of normal priority anyway.
  void yield() noexcept override;
  /// Reads CLOCK_THREAD_CPUTIME_ID.
  [[nodiscard]] std::chrono::nanoseconds cpu_time() const noexcept override;
};

/// A clock that moves only on request. Any thread may read it while another one advances it: a thread that reads a time
/// also sees everything written before the clock was moved there.
class VirtualClock final : public Clock {
 public:
  /// Starts at `start`; each spin() advances the clock by `spin_step`.
  explicit VirtualClock(std::chrono::nanoseconds start = {},
                        std::chrono::nanoseconds spin_step = std::chrono::microseconds{1}) noexcept;
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override;
  /// Advances the clock to `deadline`, never back.
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  /// Advances the clock by one spin step.
  void spin() noexcept override;
  /// Advances the clock by `step` (>= 0; a negative step is ignored).
  void advance(std::chrono::nanoseconds step) noexcept;

 private:
  std::atomic<std::chrono::nanoseconds::rep> now_ns_;
  std::chrono::nanoseconds spin_step_;
};

}  // namespace driveline::rt
