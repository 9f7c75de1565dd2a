#include "driveline/trajectory/rejoin.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Share of the acceleration limit for braking towards the path; the rest is reserved for the path's own acceleration.
constexpr double kBrakingShare = 0.25;
/// Decay rate of a small deviation, per step and at most per second.
constexpr double kGainPerStep = 0.125;
constexpr double kLargestGain = 50.0;
constexpr double kStepRounding = 1.0 + 1e-6;

}  // namespace

AxisSetpoint Rejoin::step(const AxisSetpoint& target, double period_s) noexcept {
  // The deviation one step ago, when the path was a step before `target`.
  const double most_change = limits_.max_acceleration * period_s;
  const double deviation = target.position - target.velocity * period_s - position_;
  const double onto = (target.position - position_) / period_s;
  // The axis is close enough to step onto the path within the change allowed per step; or it is on the path, and the
  // path stays within the limits, with velocities that match its positions.
  const bool near = std::abs(deviation) <= 0.25 * most_change * period_s &&
                    std::abs(target.velocity - velocity_) <= 0.5 * most_change;
  const double fastest = std::max(limits_.max_velocity, std::abs(target.velocity));
  const bool stays = joined_ && std::abs(onto - velocity_) <= kStepRounding * most_change &&
                     std::abs(onto) <= kStepRounding * fastest &&
                     std::abs(target.velocity - onto) <= kStepRounding * most_change;
  if (near || stays) {
    // Velocity of this step including the remaining deviation: the next step may differ from it by the full change.
    velocity_ = onto;
    position_ = target.position;
    joined_ = true;
    return target;
  }
  joined_ = false;
  // Approach as fast as braking allows, at the end in proportion to the deviation.
  const double gain = std::min(kGainPerStep / period_s, kLargestGain);
  const double braking = std::sqrt(2.0 * kBrakingShare * limits_.max_acceleration * std::abs(deviation));
  const double closing = std::copysign(std::min(braking, gain * std::abs(deviation)), deviation);
  // An axis that starts above its velocity limit slows down within its acceleration limit, too.
  const double wanted = std::clamp(target.velocity + closing, -fastest, fastest);
  const double velocity = velocity_ + std::clamp(wanted - velocity_, -most_change, most_change);
  const double acceleration = (velocity - velocity_) / period_s;
  position_ += velocity * period_s;
  velocity_ = velocity;
  return {position_, velocity_, acceleration};
}

}  // namespace driveline::trajectory
