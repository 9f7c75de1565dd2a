#include "driveline/trajectory/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "driveline/trajectory/rejoin.hpp"

namespace driveline::trajectory {
namespace {

/// Minimum share of the velocity limit for the return, regardless of the path.
constexpr double kLeastVelocity = 0.01;
/// Minimum and maximum share of the acceleration limit for the return.
constexpr double kLeastReserve = 0.05;
constexpr double kMaxShare = 0.1;
/// Share of the acceleration limit for braking an axis that is too fast.
constexpr double kTooFastShare = 0.4;

}  // namespace

/// Initialises the deviation relative to the path one step ago.
void Deviation::begin(const AxisSetpoint& target, double period_s) noexcept {
  const double acceleration = std::clamp(target.acceleration, -limits_.max_acceleration, limits_.max_acceleration);
  const double before = target.velocity - acceleration * period_s;
  last_velocity_ = velocity_;
  position_ -= target.position - 0.5 * (before + target.velocity) * period_s;
  velocity_ -= before;
  begun_ = true;
}

AxisSetpoint Deviation::step(const AxisSetpoint& target, double period_s) noexcept {
  if (!begun_) begin(target, period_s);
  const AxisLimits spare{
      std::max(limits_.max_velocity - std::abs(target.velocity), kLeastVelocity * limits_.max_velocity),
      std::clamp(limits_.max_acceleration - std::abs(target.acceleration), kLeastReserve * limits_.max_acceleration,
                 kMaxShare * limits_.max_acceleration)};
  Rejoin way(position_, velocity_, spare);
  const auto deviation = way.step({}, period_s);
  joined_ = way.joined();
  const double before = std::exchange(last_velocity_, allowed(target.velocity, deviation.velocity, period_s));
  const double cut = target.velocity + deviation.velocity - last_velocity_;
  velocity_ = deviation.velocity - cut;
  position_ = deviation.position - cut * period_s;
  // While the velocity is limited, the acceleration of the path does not apply.
  const double acceleration =
      std::abs(cut) > 0.0 ? (last_velocity_ - before) / period_s : target.acceleration + deviation.acceleration;
  return {target.position + position_, last_velocity_, acceleration, target.torque};
}

/// Limits the velocity to the axis limit or the velocity of the path; an axis that is faster slows down.
double Deviation::allowed(double path, double deviation, double period_s) const noexcept {
  const double slower = std::abs(last_velocity_) - kTooFastShare * limits_.max_acceleration * period_s;
  const double most = std::max({limits_.max_velocity, std::abs(path), slower});
  return std::clamp(path + deviation, -most, most);
}

}  // namespace driveline::trajectory
