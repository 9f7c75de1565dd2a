#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>
#include <limits>

/// Conversion between `timespec` and std::chrono, the only place for it. All arithmetic is 64 bit, whatever the width
/// of time_t or long.
namespace driveline::rt {

/// Nanoseconds per second.
inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// Converts `time` to seconds and nanoseconds with tv_nsec always in 0 .. 999'999'999, as the kernel requires (negative
/// times round tv_sec down). \rtsafe
[[nodiscard]] constexpr std::timespec to_timespec(std::chrono::nanoseconds time) noexcept {
  std::int64_t seconds = time.count() / kNanosecondsPerSecond;
  std::int64_t nanoseconds = time.count() % kNanosecondsPerSecond;
  if (nanoseconds < 0) {
    nanoseconds += kNanosecondsPerSecond;
    --seconds;
  }
  std::timespec result{};
  result.tv_sec = static_cast<std::time_t>(seconds);
  result.tv_nsec = static_cast<decltype(result.tv_nsec)>(nanoseconds);
  return result;
}

/// Converts `time` to nanoseconds; saturates at the limits of the type (292 years either side of the epoch). \rtsafe
[[nodiscard]] constexpr std::chrono::nanoseconds from_timespec(const std::timespec& time) noexcept {
  const std::int64_t seconds = time.tv_sec;
  const std::int64_t nanoseconds = time.tv_nsec;
  std::int64_t total = 0;
  if (__builtin_mul_overflow(seconds, kNanosecondsPerSecond, &total) ||
      __builtin_add_overflow(total, nanoseconds, &total)) {
    using Limits = std::numeric_limits<std::int64_t>;
    return std::chrono::nanoseconds{seconds < 0 ? Limits::min() : Limits::max()};
  }
  return std::chrono::nanoseconds{total};
}

}  // namespace driveline::rt
