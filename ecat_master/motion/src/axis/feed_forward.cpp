#include "driveline/motion/axis/feed_forward.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::motion {

double FeedForward::torque(const trajectory::AxisSetpoint& setpoint) const noexcept {
  if (!any()) return 0.0;
  const double share = std::clamp(setpoint.velocity / coulomb_velocity, -1.0, 1.0);
  double torque = viscous_friction * setpoint.velocity + coulomb_friction * share + gravity;
  if (pendulum > 0.0) torque += pendulum * std::sin(setpoint.position - pendulum_zero);
  return torque;
}

}  // namespace driveline::motion
