#pragma once

#include <cstdint>

namespace driveline::slaves::position_servo {

/// Reaction to a limit of the travel (607Dh:3, PositionServo CANopen manual, lines 3355-3361).
enum class LimitMode : std::uint8_t {
  kOff = 0,      ///< the limit has no effect
  kDisable = 1,  ///< the drive is disabled at once, with a fault
  kStop = 2,     ///< the axis decelerates to standstill, with a fault
};

/// Settings of the limits. The software limits are off when both positions are equal (ours).
struct LimitSettings {
  LimitMode software = LimitMode::kOff;  ///< 607Dh:3
  std::int32_t negative = 0;             ///< in counts (607Dh:1)
  std::int32_t positive = 0;             ///< in counts (607Dh:2)
  LimitMode switches = LimitMode::kOff;  ///< reaction to both limit switches (reconstruction)
};

/// What the axis does in one control period.
struct LimitInputs {
  bool negative_switch = false;  ///< limit switch at the negative end is active
  bool positive_switch = false;  ///< limit switch at the positive end is active
  std::int64_t position = 0;     ///< actual position in counts
  int direction = 0;             ///< direction of the demand: -1, 0, 1
};

/// Limit switches and software limits of the travel: a limit acts on a motion further into it, never on the way back.
class TravelLimits {
 public:
  /// The reaction that the drive now has to perform.
  enum class Reaction : std::uint8_t {
    kNone,     ///< none
    kStop,     ///< decelerate to standstill and remove all moves
    kDisable,  ///< switch the power off
  };

  /// Sets the modes and positions. \rtsafe
  void configure(const LimitSettings& settings) noexcept { settings_ = settings; }
  /// Runs one control period and returns the strongest reaction that begins in it; a reaction that was returned is not
  /// returned again before the axis has left the limit or turned back. Homing does not call it: its methods use the
  /// limit switches. \rtsafe
  Reaction step(const LimitInputs& inputs) noexcept;

  /// Whether the negative limit switch was active in the last period, in every mode (1002h bit 29). \rtsafe
  [[nodiscard]] bool negative_switch() const noexcept { return negative_switch_; }
  /// Whether the positive limit switch was active in the last period, in every mode (1002h bit 28). \rtsafe
  [[nodiscard]] bool positive_switch() const noexcept { return positive_switch_; }

 private:
  [[nodiscard]] LimitMode hit(const LimitInputs& inputs) const noexcept;

  LimitSettings settings_;
  LimitMode active_ = LimitMode::kOff;
  bool negative_switch_ = false;
  bool positive_switch_ = false;
};

}  // namespace driveline::slaves::position_servo
