// Positions of a single axis with a modulo, after which positions repeat.
#include <cmath>

#include "driveline/motion/single_axis/single_axis.hpp"
#include "driveline/trajectory/velocity_profile.hpp"

namespace driveline::motion {

using trajectory::AxisSetpoint;

/// Target position that MoveDirection selects, in drive positions.
double SingleAxis::place_of(const AxisRequest& request, const AxisSetpoint& from) const noexcept {
  const auto& config = axis_->config();
  const double modulo = *config.modulo;
  const double rest = resting_place(request, from);
  const double nearest = std::remainder(request.target_si - offset_ - rest, modulo);
  // An axis that is already there, apart from rounding, does not make a full turn.
  const double nothing = 0.5 / config.increments_per_unit;
  if (request.direction == MoveDirection::kPositive && nearest < -nothing) return rest + nearest + modulo;
  if (request.direction == MoveDirection::kNegative && nearest > nothing) return rest + nearest - modulo;
  return rest + nearest;
}

/// Position where a moving axis comes to rest if it brakes as the request says.
double SingleAxis::resting_place(const AxisRequest& request, const AxisSetpoint& from) const noexcept {
  const auto way = trajectory::plan_to_standstill(from, limits_of(request, from.velocity, from));
  return way ? way->evaluate(way->duration_s()).position : from.position;
}

}  // namespace driveline::motion
