#include "brake.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Brakes an axis that is too fast forwards, or will be: the acceleration falls and, if it ends up lower than allowed
/// at the largest velocity, rises to the allowed value. `sign` -1: the axis is inverted.
void brake_velocity(Brake& state, double sign, double fall, double top, double bottom) noexcept {
  const double velocity = sign * state.velocity;
  const double acceleration = sign * state.acceleration;
  // The hardest deceleration at the largest velocity that does not lead beyond the largest backward velocity.
  const double hardest = std::min(fall, std::sqrt(2.0 * (top + bottom)));
  const double excess = velocity - top;
  const double direct = std::sqrt(std::max(0.0, acceleration * acceleration + 2.0 * excess));
  double end = direct;
  if (direct <= hardest) {
    state.phases.push(acceleration + direct, sign * acceleration, -sign);
  } else {
    const double squared = excess + (acceleration * acceleration + hardest * hardest) / 2.0;
    const double deepest = std::min(fall, std::sqrt(squared));
    state.phases.push(acceleration + deepest, sign * acceleration, -sign);
    state.phases.push((squared - deepest * deepest) / fall, -sign * deepest, 0.0);
    state.phases.push(deepest - hardest, -sign * deepest, sign);
    end = hardest;
  }
  state.velocity = sign * top;
  state.acceleration = -sign * end;
}

bool exceeds(double velocity, double limit) noexcept {
  return velocity > limit * (1.0 + kRounding);
}

}  // namespace

Brake brake_acceleration(double velocity, double acceleration, double rise, double fall) noexcept {
  Brake state{{}, velocity, acceleration};
  const double inside = std::clamp(acceleration, -fall, rise);
  if (exceeds(acceleration, rise) || exceeds(-acceleration, fall)) {
    const double duration_s = std::abs(acceleration - inside);
    state.phases.push(duration_s, acceleration, acceleration > inside ? -1.0 : 1.0);
    state.velocity += duration_s * (acceleration + inside) / 2.0;
    state.acceleration = inside;
  }
  return state;
}

Brake brake_with_jerk(double velocity, double acceleration, const Boundary& limits) noexcept {
  Brake state = brake_acceleration(velocity, acceleration, limits.rise, limits.fall);
  // Change of the velocity while the acceleration is reduced to zero.
  const double rest = state.acceleration * state.acceleration / 2.0;
  const double v = state.velocity;
  const bool gets_above = state.acceleration > 0.0 && exceeds(v + rest, limits.top);
  const bool gets_below = state.acceleration < 0.0 && exceeds(rest - v, limits.bottom);
  if (gets_above || (!gets_below && exceeds(v, limits.top))) {
    brake_velocity(state, 1.0, limits.fall, limits.top, limits.bottom);
  } else if (gets_below || exceeds(-v, limits.bottom)) {
    brake_velocity(state, -1.0, limits.rise, limits.bottom, limits.top);
  }
  return state;
}

Brake brake_at_once(double velocity, const Boundary& limits) noexcept {
  Brake state{{}, velocity, 0.0};
  if (exceeds(velocity, limits.top)) {
    state.phases.push((velocity - limits.top) / limits.fall, -limits.fall, 0.0);
    state.velocity = limits.top;
  } else if (exceeds(-velocity, limits.bottom)) {
    state.phases.push((-velocity - limits.bottom) / limits.rise, limits.rise, 0.0);
    state.velocity = -limits.bottom;
  }
  return state;
}

}  // namespace driveline::trajectory
