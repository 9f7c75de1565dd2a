#pragma once

#include "driveline/ecat_master/cyclic/setpoint_supply.hpp"
#include "driveline/trajectory/deviation.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/rejoin.hpp"

namespace driveline::ecat_master {

/// The way of an axis back to its setpoints behind a gap: as fast as its limits allow, but in CST gently, since there a
/// leap of the acceleration is answered by the loops of the master some cycles late. A plain value.
class WayBack {
 public:
  /// From the last setpoint that left.
  WayBack(const SetpointSupply& supply, const trajectory::AxisLimits& limits) noexcept
      : gently_(supply.by_torque()),
        rejoin_(supply.sent(), supply.sent_velocity(), limits),
        deviation_(supply.sent(), supply.sent_velocity(), limits) {}

  /// The setpoint one step of `period_s` later, when that of the motion is `target`. \rtsafe
  [[nodiscard]] trajectory::AxisSetpoint step(const trajectory::AxisSetpoint& target, double period_s) noexcept {
    return gently_ ? deviation_.step(target, period_s) : rejoin_.step(target, period_s);
  }
  /// Whether the last one was that of the motion itself. \rtsafe
  [[nodiscard]] bool joined() const noexcept { return gently_ ? deviation_.joined() : rejoin_.joined(); }

 private:
  bool gently_;
  trajectory::Rejoin rejoin_;
  trajectory::Deviation deviation_;
};

}  // namespace driveline::ecat_master
