#pragma once

#include <algorithm>
#include <cstdint>

namespace driveline::slaves::msd {

/// Distinguishes a wrong bus cycle from late, lost or duplicated frames: the cycle is wrong when none of many
/// consecutive setpoints arrived close to its expected time. Numbers: ours.
class SetpointRhythm {
 public:
  /// Counts a control cycle. \rtsafe
  void step() noexcept { since_ = std::min(since_ + 1, kLongest); }
  /// Counts a setpoint; setpoints are expected every `steps` control cycles. \rtsafe
  void sample(std::uint32_t steps) noexcept {
    // Tolerance: a quarter of the period. With the right cycle, jitter puts intervals on both sides of the period.
    fast_ = 4ULL * since_ <= 3ULL * steps ? std::min(fast_ + 1, kProof) : 0;
    slow_ = 4ULL * since_ >= 5ULL * steps ? std::min(slow_ + 1, kProof) : 0;
    since_ = 0;
  }
  /// Whether the setpoints arrive in another cycle. \rtsafe
  [[nodiscard]] bool wrong() const noexcept { return fast_ == kProof || slow_ == kProof; }

 private:
  static constexpr std::uint32_t kProof = 256;  ///< consecutive setpoints
  static constexpr std::uint32_t kLongest = 0xFFFFFFU;

  std::uint32_t since_ = 0;  ///< control cycles since the last setpoint
  std::uint32_t fast_ = 0;
  std::uint32_t slow_ = 0;
};

}  // namespace driveline::slaves::msd
