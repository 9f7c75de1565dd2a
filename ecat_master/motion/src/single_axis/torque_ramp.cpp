#include "driveline/motion/single_axis/torque_ramp.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::motion {
namespace {

/// Time constant of the acceleration filter, s.
constexpr double kAccelerationFilterS = 5e-3;
/// Factor by which, and time in s for which, an axis may exceed its velocity limit: a velocity is measured late.
constexpr double kSpareVelocity = 1.1;
constexpr double kSpareTimeS = 0.01;
/// Share of max_acceleration that brakes an axis that is faster than torque control permits; the load also acts on it.
constexpr double kBrakingShare = 0.8;

}  // namespace

void TorqueRamp::permit(double velocity) noexcept {
  top_ = std::abs(velocity);
}

void TorqueRamp::start(double torque, double velocity) noexcept {
  torque_ = torque;
  velocity_before_ = velocity;
  top_ = std::abs(velocity);
  acceleration_ = 0.0;
  too_fast_s_ = 0.0;
}

void TorqueRamp::measure(double velocity, double period_s) noexcept {
  acceleration_ +=
      std::min(period_s / kAccelerationFilterS, 1.0) * ((velocity - velocity_before_) / period_s - acceleration_);
  velocity_before_ = velocity;
}

bool TorqueRamp::advance(double target, double step, double velocity, const Limits& limits, double period_s) noexcept {
  torque_ += std::clamp(target - torque_, -step, step);
  const double slower = top_ - kBrakingShare * limits.max_acceleration * period_s;
  top_ = std::max(velocity, slower);
  return !(std::abs(target - torque_) > 0.0);
}

double TorqueRamp::torque(double velocity, const Limits& limits) const noexcept {
  return std::clamp(torque_, limits.velocity_gain * (-top_ - velocity), limits.velocity_gain * (top_ - velocity));
}

bool TorqueRamp::too_fast(double velocity, const Limits& limits, double period_s) noexcept {
  const bool over = std::abs(velocity) > kSpareVelocity * limits.max_velocity;
  too_fast_s_ = over ? too_fast_s_ + period_s : 0.0;
  return too_fast_s_ > kSpareTimeS;
}

}  // namespace driveline::motion
