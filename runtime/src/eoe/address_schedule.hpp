#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace driveline::runtime {

/// Determines when to set the IP parameters of a slave: whenever its mailboxes have been opened, and again with growing
/// pauses while it does not answer.
class AddressSchedule {
 public:
  static constexpr std::chrono::nanoseconds kFirstPause = std::chrono::seconds{1};
  static constexpr std::chrono::nanoseconds kLongestPause = std::chrono::minutes{1};

  /// Whether to set the parameters now. Call while the mailboxes are open; `openings` counts how often they were
  /// opened. Returns true once per occasion.
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
  /// Reports that the slave has not answered. Returns true the first time since its mailboxes were opened.
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
