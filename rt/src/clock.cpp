#include "driveline/rt/clock.hpp"

#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

#include "driveline/rt/time_conversion.hpp"

namespace driveline::rt {

std::chrono::nanoseconds MonotonicClock::now() const noexcept {
  std::timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);  // cannot fail: the clock exists on every Linux and the pointer is valid
  return from_timespec(time);
}

void MonotonicClock::sleep_until(std::chrono::nanoseconds deadline) noexcept {
  if (deadline <= std::chrono::nanoseconds::zero()) {
    return;  // before the epoch; the kernel would refuse such a time
  }
  const std::timespec time = to_timespec(deadline);
  int result = 0;
  do {
    result = clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);  // the error is returned, not in errno
  } while (result == EINTR);
  // By the manual no error is possible here; if a sandbox forbids the call, the promise "not before the deadline" must
  // still hold.
  while (result != 0 && now() < deadline) {
    spin();
  }
}

void MonotonicClock::spin() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__) || defined(__arm__)
  asm volatile("yield");
#endif
}

/// The instant is detected half an iteration late on average, so the last iterations only read the clock: a pause takes
/// as long as a reading.
std::chrono::nanoseconds MonotonicClock::spin_until(std::chrono::nanoseconds instant) noexcept {
  constexpr std::chrono::nanoseconds kWithoutPause = std::chrono::microseconds{1};
  while (now() + kWithoutPause < instant) spin();
  const std::timespec until = to_timespec(std::max(instant, std::chrono::nanoseconds::zero()));
  std::timespec time{};
  do {
    clock_gettime(CLOCK_MONOTONIC, &time);
  } while (time.tv_sec < until.tv_sec || (time.tv_sec == until.tv_sec && time.tv_nsec < until.tv_nsec));
  return from_timespec(time);
}

void MonotonicClock::yield() noexcept {
  const int policy = sched_getscheduler(0);
  if (policy == SCHED_FIFO || policy == SCHED_RR) sched_yield();  // cannot fail on Linux
}

std::chrono::nanoseconds MonotonicClock::cpu_time() const noexcept {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return from_timespec(time);
}

VirtualClock::VirtualClock(std::chrono::nanoseconds start, std::chrono::nanoseconds spin_step) noexcept
    : now_ns_{start.count()}, spin_step_{spin_step} {}

std::chrono::nanoseconds VirtualClock::now() const noexcept {
  return std::chrono::nanoseconds{now_ns_.load(std::memory_order_acquire)};
}

void VirtualClock::sleep_until(std::chrono::nanoseconds deadline) noexcept {
  auto current = now_ns_.load(std::memory_order_relaxed);
  while (current < deadline.count() &&
         !now_ns_.compare_exchange_weak(current, deadline.count(), std::memory_order_acq_rel)) {
  }
}

void VirtualClock::spin() noexcept {
  advance(spin_step_);
}

void VirtualClock::advance(std::chrono::nanoseconds step) noexcept {
  if (step > std::chrono::nanoseconds::zero()) {
    now_ns_.fetch_add(step.count(), std::memory_order_acq_rel);
  }
}

}  // namespace driveline::rt
