#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// A fault in the actual positions of an axis. Lengths are rad or m.
struct PositionFinding {
  /// Kind of fault.
  enum class Kind : std::uint8_t {
    kNone,
    kLeap,    ///< went further at once than the axis can
    kFrozen,  ///< stood still to the increment while the axis was sent on
    /// Went further than it can when the axis was enabled: new units, or a new zero, count from there on. Nothing is
    /// wrong, but the axis has to be held at another place.
    kNewPlace,
  };
  Kind kind = Kind::kNone;  ///< kNone: no fault
  double from = 0.0;        ///< the last position that could be true
  double moved = 0.0;       ///< kLeap: the step from there; kFrozen: how far the setpoint has gone meanwhile
  double allowed = 0.0;     ///< how far it may be
  double within_s = 0.0;    ///< the time that it took

  /// Whether there is a fault. \rtsafe
  [[nodiscard]] explicit operator bool() const noexcept { return kind == Kind::kLeap || kind == Kind::kFrozen; }
};

/// Judges whether the actual positions that a drive reports can be true: whether a step is one that the axis can do by
/// its limits, and whether the axis moves when it is sent on. Positions come unwrapped, so the end of the 32 bits is no
/// step. While the axis is not driven any step is a new beginning (homing, a new zero, other factors), but no place to
/// be enabled at until the positions have been steady for a while.
///
/// Belongs to the cycle; all but the constructor is \rtsafe.
class PositionWatch {
 public:
  /// Exchanges, and time, without an implausible step until a position counts as steady.
  static constexpr std::uint32_t kSteadyExchanges = 8;
  static constexpr std::chrono::milliseconds kSteadyTime{5};  ///< see kSteadyExchanges
  /// Positions that stand for shorter are those of a drive that measures less often than it is asked.
  static constexpr std::chrono::milliseconds kFrozenTime{50};

  /// `period`: of the line's cycle. With AxisConfig::position_tolerance = 0 everything is plausible.
  PositionWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept;

  /// The position that was exchanged in this cycle, and the setpoint in force. `driven`: the drive follows setpoints.
  /// `took`: the exchange; one that was held up for longer than a cycle may bring a position that is younger than the
  /// cycle by as much.
  [[nodiscard]] PositionFinding judge(std::int64_t cycle, double position, const trajectory::AxisSetpoint& setpoint,
                                      bool driven, std::chrono::nanoseconds took = {}) noexcept;
  /// The axis is not there: the next position is a new beginning.
  void forget() noexcept;

  /// Positions are there, and have been plausible for long enough to enable the axis at the last one.
  [[nodiscard]] bool steady() const noexcept { return steady_; }
  /// The last steady position; the first one when there was none since forget().
  [[nodiscard]] double held() const noexcept { return held_; }
  /// The last implausible step of an axis that was not driven; kNone: there was none since it was steady.
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
  std::int64_t change_cycle_ = 0;  ///< in which the position was another one than before
  double last_ = 0.0;
  double held_ = 0.0;
  double setpoint_at_change_ = 0.0;
  PositionFinding unsteady_;
};

}  // namespace driveline::ecat_master
