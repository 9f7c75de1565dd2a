#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace driveline::runtime {

/// When a slave is given its IP parameters: whenever its mailboxes have been opened, and again with growing pauses
/// while it does not answer.
class AddressSchedule {
 public:
  static constexpr std::chrono::nanoseconds kFirstPause = std::chrono::seconds{1};
  static constexpr std::chrono::nanoseconds kLongestPause = std::chrono::minutes{1};

  /// Now, the mailboxes being open and having been opened `openings` times? Says so once.
  [[nodiscard]] bool due(std::uint64_t openings, std::chrono::nanoseconds now) noexcept {
    if (openings != openings_) {
      openings_ = openings;
      pause_ = kFirstPause;
      silent_ = false;
      return true;
    }
    if (!silent_ || now < again_at_) return false;
    silent_ = false;
    return true;
  }
  /// It has not answered. True: for the first time since its mailboxes were opened.
  bool no_answer(std::chrono::nanoseconds now) noexcept {
    const bool first = pause_ == kFirstPause;
    silent_ = true;
    again_at_ = now + pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
    return first;
  }

 private:
  std::uint64_t openings_ = 0;
  std::chrono::nanoseconds pause_ = kFirstPause;
  std::chrono::nanoseconds again_at_{0};
  bool silent_ = false;
};

}  // namespace driveline::runtime
