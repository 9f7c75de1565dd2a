#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace driveline::slaves::msd {

/// Distinguishes a wrong bus cycle from late, lost or duplicated frames: the cycle is wrong when none of many
/// consecutive setpoints arrived close to its expected time. Numbers: ours.
class SetpointRhythm {
 public:
  /// Starts in this control cycle, without setpoints. \rtsafe
  void restart(std::uint64_t cycle) noexcept {
    last_ = cycle;
    fast_ = slow_ = 0;
  }
  /// Counts a setpoint that arrived in this control cycle; setpoints are expected every `steps` of them. \rtsafe
  void sample(std::uint64_t cycle, std::uint32_t steps) noexcept {
    // Tolerance: a quarter of the period. With the right cycle, jitter puts intervals on both sides of the period.
    const std::uint64_t quarters = 4 * std::min(cycle - std::exchange(last_, cycle), kLongest);
    const std::uint64_t shortest = 3ULL * steps;
    const std::uint64_t longest = shortest + 2ULL * steps;
    if (shortest < quarters && quarters < longest) {
      fast_ = slow_ = 0;
    } else {
      fast_ = quarters <= shortest ? std::min(fast_ + 1, kProof) : 0;
      slow_ = quarters >= longest ? std::min(slow_ + 1, kProof) : 0;
    }
  }
  /// Whether the setpoints arrive in another cycle. \rtsafe
  [[nodiscard]] bool wrong() const noexcept { return fast_ == kProof || slow_ == kProof; }

 private:
  static constexpr std::uint32_t kProof = 256;  ///< consecutive setpoints
  static constexpr std::uint64_t kLongest = 0xFFFFFFU;

  std::uint64_t last_ = 0;  ///< control cycle of the last setpoint
  std::uint32_t fast_ = 0;
  std::uint32_t slow_ = 0;
};

}  // namespace driveline::slaves::msd
