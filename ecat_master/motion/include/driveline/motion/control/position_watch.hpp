#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// A fault of the actual positions of an axis. Lengths are rad or m.
struct PositionFinding {
  /// Kind of fault.
  enum class Kind : std::uint8_t {
    kNone,
    kLeap,    ///< moved further in one step than the axis can
    kFrozen,  ///< did not change by an increment while the axis was commanded to move
    /// A jump when the axis was enabled: new units, or a new zero, apply from there on. It is no fault, but the axis
    /// has to be held at another position.
    kNewPlace,
  };
  Kind kind = Kind::kNone;  ///< kNone: no fault
  double from = 0.0;        ///< the last plausible position
  double moved = 0.0;       ///< kLeap: the step from there; kFrozen: motion of the setpoint meanwhile
  double allowed = 0.0;     ///< largest permitted distance
  double within_s = 0.0;    ///< duration, s

  /// Whether there is a fault. \rtsafe
  [[nodiscard]] explicit operator bool() const noexcept { return kind == Kind::kLeap || kind == Kind::kFrozen; }
};

/// Checks whether the actual positions reported by a drive are plausible: whether a step is possible within the limits
/// of the axis, and whether the axis moves when it is commanded to. Positions are unwrapped, so the end of the 32 bits
/// is no step. While the axis is not driven, any step is accepted as a new start (homing, a new zero, other factors),
/// but the axis can be enabled only after its positions have been steady for a while.
///
/// For the cycle only; everything except the constructor is \rtsafe.
class PositionWatch {
 public:
  /// Exchanges, and time, without an implausible step after which a position counts as steady.
  static constexpr std::uint32_t kSteadyExchanges = 8;
  static constexpr std::chrono::milliseconds kSteadyTime{5};  ///< see kSteadyExchanges
  /// A position unchanged for less than this time may come from a drive that measures less often than it is read.
  static constexpr std::chrono::milliseconds kFrozenTime{50};

  /// `period`: cycle time of the line. With AxisConfig::position_tolerance = 0 every position is plausible.
  PositionWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept;

  /// Checks the position exchanged in this cycle against the setpoint in force. `driven`: the drive follows setpoints.
  /// `took`: duration of the exchange; an exchange delayed beyond a cycle may bring a position that is younger than the
  /// cycle by the excess.
  [[nodiscard]] PositionFinding judge(std::int64_t cycle, double position, const trajectory::AxisSetpoint& setpoint,
                                      bool driven, std::chrono::nanoseconds took = {}) noexcept;
  /// Restarts with the next position, because the axis is not available.
  void forget() noexcept;

  /// Whether positions have been plausible for long enough to enable the axis at the last one.
  [[nodiscard]] bool steady() const noexcept { return steady_; }
  /// The last steady position; if there was none since forget(), the first one.
  [[nodiscard]] double held() const noexcept { return held_; }
  /// The last implausible step while the axis was not driven; kNone: none since the position was steady.
  [[nodiscard]] const PositionFinding& unsteady() const noexcept { return unsteady_; }

 private:
  void begin(std::int64_t cycle, double position) noexcept;
  [[nodiscard]] PositionFinding step(double position, const trajectory::AxisSetpoint& setpoint,
                                     double within) const noexcept;
  [[nodiscard]] PositionFinding standstill(std::int64_t cycle, const trajectory::AxisSetpoint& setpoint) const noexcept;
  void settle(std::int64_t cycle, double position, const PositionFinding& finding) noexcept;
  [[nodiscard]] double seconds(std::int64_t cycles) const noexcept { return cycle_s_ * static_cast<double>(cycles); }

  double max_velocity_;
  double tolerance_;
  double cycle_s_;
  bool known_ = false;
  bool steady_ = false;
  bool driven_ = false;
  std::uint32_t plausible_ = 0;  ///< exchanges since the last implausible step
  std::int64_t begin_ = 0;       ///< cycle of that step
  std::int64_t last_cycle_ = 0;
  std::int64_t change_cycle_ = 0;  ///< cycle in which the position last changed
  double last_ = 0.0;
  double held_ = 0.0;
  double setpoint_at_change_ = 0.0;
  PositionFinding unsteady_;
};

}  // namespace driveline::motion
