#include "driveline/slaves/position_servo/segment.hpp"

#include <cmath>

namespace driveline::slaves::position_servo {
namespace {

constexpr bool above_zero(std::int32_t value) noexcept {
  return value > 0;
}

MotionFault check_acceleration(std::int32_t acceleration) noexcept {
  if (acceleration > kMaxAcceleration) return MotionFault::kAccelerationTooBig;
  return above_zero(acceleration) ? MotionFault::kNone : MotionFault::kAccelerationTooSmall;
}

MotionFault check_magnitude(double acceleration) noexcept {
  const double magnitude = std::abs(acceleration);
  if (magnitude > kMaxAcceleration * kAccelerationUnit) return MotionFault::kAccelerationTooBig;
  if (magnitude > 0.0 && magnitude < kAccelerationUnit) return MotionFault::kAccelerationTooSmall;
  return MotionFault::kNone;
}

}  // namespace

MotionFault check(const Move& move) noexcept {
  if (move.velocity > kMaxVelocity) return MotionFault::kVelocityTooBig;
  if (is_segment(move.type)) return move.velocity < 0 ? MotionFault::kVelocityTooSmall : MotionFault::kNone;
  if (!above_zero(move.velocity)) return MotionFault::kVelocityTooSmall;
  const MotionFault fault = check_acceleration(move.acceleration);
  if (fault != MotionFault::kNone || move.type == MoveType::kSCurve) return fault;
  return check_acceleration(move.deceleration);
}

MotionFault Segment::plan(const ProfileState& start, double target, const Move& move) noexcept {
  const double distance = target - start.position;
  const double direction = std::copysign(1.0, distance);
  const double from = start.velocity * direction;
  const double to = move.velocity * kVelocityUnit;
  const bool no_length = !(std::abs(distance) > 0.0);
  if (no_length) {
    if (std::abs(std::abs(start.velocity) - to) > 0.0) return MotionFault::kAccelerationTooBig;
  } else {
    if (from < 0.0) return MotionFault::kAccelerationTooBig;
    if (!(from + to > 0.0)) return MotionFault::kVelocityTooSmall;
    const bool s_curve = move.type == MoveType::kSegmentSCurve;
    const double mean = (to * to - from * from) / (2.0 * std::abs(distance));
    if (const MotionFault fault = check_magnitude(s_curve ? 2.0 * mean : mean); fault != MotionFault::kNone) {
      return fault;
    }
    s_curve_ = s_curve;
  }
  start_ = {start.position, start.velocity, 0.0};
  end_ = {target, no_length ? start.velocity : direction * to, 0.0};
  duration_s_ = no_length ? 0.0 : 2.0 * std::abs(distance) / (from + to);
  return MotionFault::kNone;
}

ProfileState Segment::at(double elapsed_s) const noexcept {
  if (elapsed_s >= duration_s_) return end_;
  const double t = elapsed_s;
  const double change = end_.velocity - start_.velocity;
  if (!s_curve_) {
    const double a = change / duration_s_;
    return {start_.position + t * (start_.velocity + 0.5 * a * t), start_.velocity + a * t, a};
  }
  const double jerk = 4.0 * change / (duration_s_ * duration_s_);
  if (t < 0.5 * duration_s_) {
    return {start_.position + t * (start_.velocity + jerk * t * t / 6.0), start_.velocity + 0.5 * jerk * t * t,
            jerk * t};
  }
  const double u = duration_s_ - t;
  return {end_.position - u * (end_.velocity - jerk * u * u / 6.0), end_.velocity - 0.5 * jerk * u * u, jerk * u};
}

}  // namespace driveline::slaves::position_servo
