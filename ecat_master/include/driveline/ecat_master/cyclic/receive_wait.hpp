#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/rt/wake_margin.hpp"

namespace driveline::ecat_master {

/// How a cycle waits for the answers to its frames.
enum class ReceiveStrategy : std::uint8_t {
  kSpin,   ///< looks again and again from the sending on
  kSleep,  ///< sleeps until shortly before the earliest return to be expected (ReceiveWait), then looks again and again
  kBlock,  ///< sleeps in the port until a frame comes
};

/// Until when a cycle may sleep before it looks for its answers, so that it looks already when they come. Learns both:
/// how soon they come, and how late this thread wakes. Belongs to one thread. All functions are \rtsafe.
///
/// A return that is shorter than expected counts at once, a longer one moves the expectation by 5 ns. When answers are
/// there already although the thread wakes before they are expected, it is unknown how long: they are expected an
/// eighth earlier than that.
class ReceiveWait {
 public:
  /// No sleep shorter than this: going to sleep and waking up costs about as much. With the margin at the start answers
  /// within 60 us are never slept for.
  static constexpr std::chrono::nanoseconds kShortestSleep = std::chrono::microseconds{20};
  /// How long it looks before the answer is expected, when it has woken as late as 99 of 100 times.
  static constexpr std::chrono::nanoseconds kLooksAhead = std::chrono::microseconds{5};
  /// Time for waking up that is allowed for before anything has been learned: that of an idle virtual processor.
  static constexpr std::chrono::nanoseconds kFirstMargin = std::chrono::microseconds{35};

  /// `window`: longest wait for an answer.
  explicit constexpr ReceiveWait(std::chrono::nanoseconds window) noexcept
      : window_(window), margin_(std::max(kFirstMargin, window / 4), kFirstMargin) {}

  /// When to wake for answers to frames that left at `sent`; none: they come too soon, or nothing is known of them.
  [[nodiscard]] constexpr std::optional<std::chrono::nanoseconds> wake_at(
      std::chrono::nanoseconds sent) const noexcept {
    const auto sleep = earliest_ - margin_.value() - kLooksAhead;
    if (sleep < kShortestSleep) return std::nullopt;
    return sent + sleep;
  }
  /// The sleep until `target` has ended.
  constexpr void woke(std::chrono::nanoseconds target, std::chrono::nanoseconds now) noexcept {
    margin_.observe(now - target);
  }
  /// All answers have come, the last one `took` after the sending.
  constexpr void returned(std::chrono::nanoseconds took) noexcept {
    earliest_ = earliest_ == kUnknown ? took : std::min(took, earliest_ + kUp);
    earliest_ = std::min(earliest_, window_);
  }
  /// All answers were there at the first look behind a sleep, `after` the sending. A late wake-up says nothing of them.
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
