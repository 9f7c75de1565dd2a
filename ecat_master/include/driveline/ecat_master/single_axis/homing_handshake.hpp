#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::ecat_master {

/// Homing by a drive, as bits 10, 12 and 13 of its status word tell it (CiA 402-2 "Homing mode"; MSD manual
/// Table 12.14). A result of an earlier homing stays in the status word until the drive has seen the new start, so it
/// counts only once it has gone, or the drive has had its time. A plain value; everything is \rtsafe.
class HomingHandshake {
 public:
  /// How far it is.
  enum class State : std::uint8_t {
    kRunning,
    kAttained,  ///< home was found, and the axis stands
    kFailed,
  };
  /// In which a drive has seen the start bit.
  static constexpr std::chrono::milliseconds kReaction{50};

  /// The start bit (bit 4 of the control word) is given from now on; `status_word`: the last one without it.
  void start(std::uint16_t status_word) noexcept;
  /// The status word of an exchange, so long after the start.
  [[nodiscard]] State judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept;

 private:
  std::uint16_t stale_ = 0;  ///< bits of an earlier result
};

}  // namespace driveline::ecat_master
