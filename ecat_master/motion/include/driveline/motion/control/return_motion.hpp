#pragma once

#include <cmath>

#include "driveline/motion/control/setpoint_supply.hpp"
#include "driveline/trajectory/deviation.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/rejoin.hpp"

namespace driveline::motion {

/// Return of an axis to its setpoints after a gap, as fast as its limits permit. It is gentle in CST, where the loops
/// of the master answer a jump of the acceleration some cycles late, and during a mode change, which also needs part of
/// the acceleration. A plain value.
class ReturnMotion {
 public:
  ReturnMotion() = default;
  /// Starts at the last setpoint sent.
  ReturnMotion(const SetpointSupply& supply, const trajectory::AxisLimits& limits) noexcept
      : ReturnMotion(supply.sent(), supply.sent_velocity(), supply.by_torque(), limits) {}
  /// Starts at this position (rad or m) and velocity (rad/s or m/s), `gently` or not.
  ReturnMotion(double position, double velocity, bool gently, const trajectory::AxisLimits& limits) noexcept
      : limits_(limits),
        gently_(gently),
        rejoin_(position, velocity, limits),
        deviation_(position, velocity, limits),
        last_{position, velocity} {}

  /// The setpoint one step of `period_s` later, if `target` is that of the motion; gentle from now on if the mode of
  /// the axis is `changing`. \rtsafe
  [[nodiscard]] trajectory::AxisSetpoint step(const trajectory::AxisSetpoint& target, double period_s,
                                              bool changing) noexcept {
    const bool begins = changing && !gently_;
    gently_ = gently_ || changing;
    if (begins || leaps(target, period_s)) deviation_ = {last_.position, last_.velocity, limits_};
    target_ = target;
    last_ = gently_ ? deviation_.step(target, period_s) : rejoin_.step(target, period_s);
    return last_;
  }
  /// Whether the last setpoint was that of the motion itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return gently_ ? deviation_.joined() : rejoin_.joined(); }

 private:
  /// Whether the motion jumps, so that no axis could follow it from the last step.
  [[nodiscard]] bool leaps(const trajectory::AxisSetpoint& target, double period_s) const noexcept {
    const double step = 0.5 * (target_.velocity + target.velocity) * period_s;
    return std::abs(target.position - target_.position - step) > limits_.max_acceleration * period_s * period_s;
  }

  trajectory::AxisLimits limits_{};
  bool gently_ = false;
  trajectory::Rejoin rejoin_{};
  trajectory::Deviation deviation_{};
  trajectory::AxisSetpoint target_{};  ///< target of the last step
  trajectory::AxisSetpoint last_{};
};

}  // namespace driveline::motion
