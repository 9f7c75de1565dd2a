#pragma once

#include <atomic>
#include <chrono>

namespace driveline::rt {

/// The source of time for everything that runs. Injected, never looked up, so that a whole line (master, drives,
/// clocks) can run on a clock that a test advances by hand.
///
/// Times are nanoseconds since the clock's own epoch. All functions are \rtsafe.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Current time; never runs backwards.
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;

  /// Returns at or after `deadline`; at once if it has passed.
  virtual void sleep_until(std::chrono::nanoseconds deadline) noexcept = 0;

  /// One turn of a busy-wait loop: a CPU pause in real time, a small step forward on virtual time (so that a loop
  /// that spins up to a deadline ends).
  virtual void spin() noexcept = 0;

  /// Spins until `instant`, which may have passed; the time at which it is seen to have. @return that time.
  virtual std::chrono::nanoseconds spin_until(std::chrono::nanoseconds instant) noexcept {
    auto time = now();
    for (; time < instant; time = now()) spin();
    return time;
  }

  /// One turn of a busy-wait loop that waits for another thread, which may need this very CPU: ready real-time threads
  /// of the same priority run first. Costs two system calls on the real clock: not for every turn.
  virtual void give_way() noexcept { spin(); }

  /// Time of a CPU that the calling thread has used, since an arbitrary instant. By default all time counts as used: no
  /// other thread competes on a clock that is advanced by hand. A system call on the real clock: not for every cycle.
  [[nodiscard]] virtual std::chrono::nanoseconds cpu_time() const noexcept { return now(); }
};

/// CLOCK_MONOTONIC. Any number of threads may share one.
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override;
  /// Sleeps to the absolute time; a signal handler that runs meanwhile does not shorten the sleep.
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  void spin() noexcept override;
  std::chrono::nanoseconds spin_until(std::chrono::nanoseconds instant) noexcept override;
  /// sched_yield(2) of a real-time thread; the kernel preempts threads of normal priority anyway.
  void give_way() noexcept override;
  /// CLOCK_THREAD_CPUTIME_ID.
  [[nodiscard]] std::chrono::nanoseconds cpu_time() const noexcept override;
};

/// A clock that moves only when told to. Starts at `start`. Reading it from other threads than the one that advances it
/// is safe: a thread that reads a time also sees everything written before the clock was moved there.
class VirtualClock final : public Clock {
 public:
  /// Begins at `start`; spin() moves it on by `spin_step`.
  explicit VirtualClock(std::chrono::nanoseconds start = {},
                        std::chrono::nanoseconds spin_step = std::chrono::microseconds{1}) noexcept;
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override;
  /// Moves the clock to `deadline` (never back).
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  /// Moves the clock by one spin step.
  void spin() noexcept override;
  /// Moves the clock forward by `step` (>= 0; a negative step is ignored).
  void advance(std::chrono::nanoseconds step) noexcept;

 private:
  std::atomic<std::chrono::nanoseconds::rep> now_ns_;
  std::chrono::nanoseconds spin_step_;
};

}  // namespace driveline::rt
