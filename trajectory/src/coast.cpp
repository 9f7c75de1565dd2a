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

void Coast::skip(std::int64_t periods, double period_s) noexcept {
  const auto straight =
      std::clamp<std::int64_t>(std::int64_t{straight_} - missed_, 0, std::max<std::int64_t>(periods, 0));
  missed_ += static_cast<std::uint32_t>(straight);
  go_straight(static_cast<double>(straight), period_s);
  slow_down(static_cast<double>(periods - straight), period_s);
}

void Coast::go_straight(double periods, double period_s) noexcept {
  // step() changes the velocity before the position: 1 + 2 + ... + periods changes in all.
  const double change = acceleration_ * period_s;
  position_ += (periods * velocity_ + 0.5 * periods * (periods + 1.0) * change) * period_s;
  velocity_ += periods * change;
}

void Coast::slow_down(double periods, double period_s) noexcept {
  if (!(periods > 0.0)) return;
  const double speed = std::abs(velocity_);
  const double change = deceleration_ * period_s;
  const double moving = change > 0.0 ? std::min(periods, std::floor(speed / change)) : periods;
  position_ += std::copysign((moving * speed - 0.5 * moving * (moving + 1.0) * change) * period_s, velocity_);
  velocity_ = std::copysign(std::max(speed - periods * change, 0.0), velocity_);
}

AxisSetpoint Coast::next(double period_s) const noexcept {
  Coast later = *this;
  later.step(period_s);
  return {later.position_, later.velocity_, missed_ < straight_ ? acceleration_ : 0.0};
}

}  // namespace driveline::trajectory
