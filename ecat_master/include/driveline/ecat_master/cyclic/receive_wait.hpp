#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/wake_margin.hpp"

namespace driveline::ecat_master {

/// Method by which a cycle waits for the answers to its frames.
enum class ReceiveStrategy : std::uint8_t {
  kSpin,   ///< polls from the sending on
  kSleep,  ///< sleeps until shortly before the earliest expected answer (ReceiveWait), then polls
  kBlock,  ///< sleeps in the port until a frame arrives
};

/// Computes how long a cycle may sleep before it polls for its answers, so that it is already polling when they arrive.
/// Learns the return time of the answers and the wake-up latency of the thread. One thread; all functions are \rtsafe.
///
/// A return time that is shorter than expected counts at once; a longer one raises the expectation by 5 ns. If answers
/// are already there although the thread woke before their expected time, their return time is unknown; then seven
/// eighths of the time until the first poll are expected.
class ReceiveWait {
 public:
  /// Shortest sleep: falling asleep and waking up cost about as much. With the initial margin, answers within 60 us
  /// never cause a sleep.
  static constexpr std::chrono::nanoseconds kShortestSleep = std::chrono::microseconds{20};
  /// Time of polling before the expected answer when the thread wakes as late as its 99th percentile.
  static constexpr std::chrono::nanoseconds kLooksAhead = std::chrono::microseconds{5};
  /// Wake-up latency assumed before anything has been learned: that of an idle virtual processor.
  static constexpr std::chrono::nanoseconds kFirstMargin = std::chrono::microseconds{35};

  /// `window`: longest wait for an answer.
  explicit constexpr ReceiveWait(std::chrono::nanoseconds window) noexcept
      : window_(window), margin_(std::max(kFirstMargin, window / 4), kFirstMargin) {}

  /// Time to wake up for answers to frames sent at `sent`; none: they come too soon, or nothing is known about them.
  [[nodiscard]] constexpr std::optional<std::chrono::nanoseconds> wake_at(
      std::chrono::nanoseconds sent) const noexcept {
    const auto sleep = earliest_ - margin_.value() - kLooksAhead;
    if (sleep < kShortestSleep) return std::nullopt;
    return sent + sleep;
  }
  /// Records the end of a sleep until `target`.
  constexpr void woke(std::chrono::nanoseconds target, std::chrono::nanoseconds now) noexcept {
    margin_.observe(now - target);
  }
  /// Records that all answers have arrived, the last one `took` after the sending.
  constexpr void returned(std::chrono::nanoseconds took) noexcept {
    earliest_ = earliest_ == kUnknown ? took : std::min(took, earliest_ + kUp);
    earliest_ = std::min(earliest_, window_);
  }
  /// Records that all answers were there at the first poll after a sleep, `after` the sending. A late wake-up proves
  /// nothing.
  constexpr void were_there(std::chrono::nanoseconds after) noexcept {
    if (after < earliest_) earliest_ = after - after / kDownShare;
  }

 private:
  static constexpr std::chrono::nanoseconds kUnknown{0};
  static constexpr std::chrono::nanoseconds kUp{5};
  static constexpr int kDownShare = 8;

  std::chrono::nanoseconds window_;
  std::chrono::nanoseconds earliest_ = kUnknown;
  rt::WakeMargin margin_;
};

}  // namespace driveline::ecat_master
