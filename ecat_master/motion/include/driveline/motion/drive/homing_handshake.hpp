#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::motion {

/// Homing by a drive, as reported by bits 10, 12 and 13 of its status word (CiA 402-2 "Homing mode"; MSD manual Table
/// 12.14). The result of an earlier homing stays in the status word until the drive has seen the new start, so a result
/// counts only once the old one has disappeared, or after kReaction. A plain value; everything is \rtsafe.
class HomingHandshake {
 public:
  /// Progress of homing.
  enum class State : std::uint8_t {
    kRunning,
    kAttained,  ///< home was found, and the axis is at standstill
    kFailed,
  };
  /// Time within which a drive sees the start bit.
  static constexpr std::chrono::milliseconds kReaction{50};

  /// Call when the start bit (bit 4 of the control word) is set; `status_word`: the last one before it.
  void start(std::uint16_t status_word) noexcept;
  /// Evaluates the status word of an exchange; `since`: time since the start.
  [[nodiscard]] State judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept;

 private:
  std::uint16_t stale_ = 0;  ///< bits of an earlier result
};

}  // namespace driveline::motion
