#pragma once

#include <algorithm>
#include <cstdint>

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
    const std::uint64_t since = std::min(cycle - last_, kLongest);
    fast_ = 4 * since <= 3ULL * steps ? std::min(fast_ + 1, kProof) : 0;
    slow_ = 4 * since >= 5ULL * steps ? std::min(slow_ + 1, kProof) : 0;
    last_ = cycle;
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
