#include "driveline/trajectory/coast.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {

void Coast::give(double position, double velocity, double acceleration) noexcept {
  position_ = position;
  velocity_ = velocity;
  acceleration_ = acceleration;
  missed_ = 0;
}

void Coast::step(double period_s) noexcept {
  if (missed_ < straight_) {
    ++missed_;
    velocity_ += acceleration_ * period_s;
  } else {
    velocity_ -= std::copysign(std::min(std::abs(velocity_), deceleration_ * period_s), velocity_);
  }
  position_ += velocity_ * period_s;
}

AxisSetpoint Coast::next(double period_s) const noexcept {
  Coast later = *this;
  later.step(period_s);
  return {later.position_, later.velocity_, missed_ < straight_ ? acceleration_ : 0.0};
}

}  // namespace driveline::trajectory
