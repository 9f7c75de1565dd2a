#include "driveline/trajectory/rejoin.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Share of the acceleration limit for braking towards the path: the rest is for the path's own acceleration.
constexpr double kBrakingShare = 0.25;
/// A small deviation decays at this rate, per step and at most per second.
constexpr double kGainPerStep = 0.125;
constexpr double kLargestGain = 50.0;
/// Of a limit, and of a position: rounding.
constexpr double kRejoinRounding = 1e-9;
constexpr double kStepRounding = 2e-15;

}  // namespace

AxisSetpoint Rejoin::step(const AxisSetpoint& target, double period_s) noexcept {
  // One that is on the path stays there with all that its limits allow.
  const double step_velocity = (target.position - position_) / period_s;
  const double rounding = kStepRounding * std::abs(target.position) / period_s;
  const double change = limits_.max_acceleration * period_s * (1.0 + kRejoinRounding) + rounding;
  const double fastest = std::max(limits_.max_velocity, std::abs(target.velocity)) * (1.0 + kRejoinRounding) + rounding;
  if (joined_ && std::abs(step_velocity) <= fastest && std::abs(step_velocity - velocity_) <= change) {
    velocity_ = step_velocity;
    position_ = target.position;
    return target;
  }
  // The deviation as it was one step ago, when the path was a step behind `target`.
  const double deviation = target.position - target.velocity * period_s - position_;
  const double most_change = limits_.max_acceleration * period_s;
  // Near enough to step onto the path with what one step may change.
  const bool near = std::abs(deviation) <= 0.25 * most_change * period_s;
  if (near && std::abs(target.velocity - velocity_) <= 0.5 * most_change) {
    // Of the step, in which the rest of the deviation is as well: the next one may change it by as much as any.
    velocity_ = step_velocity;
    position_ = target.position;
    joined_ = true;
    return target;
  }
  joined_ = false;
  // As fast as braking allows, in the end proportional to the deviation.
  const double gain = std::min(kGainPerStep / period_s, kLargestGain);
  const double braking = std::sqrt(2.0 * kBrakingShare * limits_.max_acceleration * std::abs(deviation));
  const double closing = std::copysign(std::min(braking, gain * std::abs(deviation)), deviation);
  // An axis that is faster than the limit at the start is slowed down within its acceleration limit, too.
  const double top = std::max(limits_.max_velocity, std::abs(target.velocity));
  const double wanted = std::clamp(target.velocity + closing, -top, top);
  const double velocity = velocity_ + std::clamp(wanted - velocity_, -most_change, most_change);
  const double acceleration = (velocity - velocity_) / period_s;
  position_ += velocity * period_s;
  velocity_ = velocity;
  return {position_, velocity_, acceleration};
}

}  // namespace driveline::trajectory
