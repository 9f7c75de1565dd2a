#pragma once

#include <cmath>

#include "driveline/ecat_master/cyclic/setpoint_supply.hpp"
#include "driveline/trajectory/deviation.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/rejoin.hpp"

namespace driveline::ecat_master {

/// The way of an axis back to its setpoints behind a gap: as fast as its limits allow, but in CST gently, since there a
/// leap of the acceleration is answered by the loops of the master some cycles late, and while its mode changes, which
/// takes some of the acceleration as well. A plain value.
class WayBack {
 public:
  WayBack() = default;
  /// From the last setpoint that left.
  WayBack(const SetpointSupply& supply, const trajectory::AxisLimits& limits) noexcept
      : WayBack(supply.sent(), supply.sent_velocity(), supply.by_torque(), limits) {}
  /// From this position (rad or m) and velocity, `gently` or not.
  WayBack(double position, double velocity, bool gently, const trajectory::AxisLimits& limits) noexcept
      : limits_(limits),
        gently_(gently),
        rejoin_(position, velocity, limits),
        deviation_(position, velocity, limits),
        last_{position, velocity} {}

  /// The setpoint one step of `period_s` later, when that of the motion is `target`; gently from now on if the mode of
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
  /// Whether the last one was that of the motion itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return gently_ ? deviation_.joined() : rejoin_.joined(); }

 private:
  /// Where the motion does not go on from the last step no axis could go with it.
  [[nodiscard]] bool leaps(const trajectory::AxisSetpoint& target, double period_s) const noexcept {
    const double step = 0.5 * (target_.velocity + target.velocity) * period_s;
    return std::abs(target.position - target_.position - step) > limits_.max_acceleration * period_s * period_s;
  }

  trajectory::AxisLimits limits_{};
  bool gently_ = false;
  trajectory::Rejoin rejoin_{};
  trajectory::Deviation deviation_{};
  trajectory::AxisSetpoint target_{};  ///< of the last step, which it made
  trajectory::AxisSetpoint last_{};
};

}  // namespace driveline::ecat_master
