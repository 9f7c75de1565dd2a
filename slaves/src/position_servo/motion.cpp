#include "driveline/slaves/position_servo/motion.hpp"

#include <algorithm>

namespace driveline::slaves::position_servo {
namespace {

/// An S-curve has no jerk of its own: its acceleration rises to 6083h and falls back at once in a change of speed from
/// 0 to 6081h, so that its jerk is 6083h^2 / 6081h (ours; the manual leaves the jerk open).
GeneratorLimits limits_of(const Move& move) noexcept {
  const double velocity = move.velocity * kVelocityUnit;
  const double acceleration = move.acceleration * kAccelerationUnit;
  if (move.type == MoveType::kSCurve) return {velocity, acceleration, acceleration, velocity / acceleration};
  return {velocity, acceleration, move.deceleration * kAccelerationUnit, 0.0};
}

double braking(std::int32_t deceleration) noexcept {
  return std::clamp(deceleration, 1, kMaxAcceleration) * kAccelerationUnit;
}

}  // namespace

void Motion::reset(double position) noexcept {
  queue_.clear();
  demand_ = {position, 0.0, 0.0};
  generator_.reset(demand_);
  phase_ = Phase::kIdle;
  marked_ = false;
}

void Motion::enable(bool on) noexcept {
  if (!on) reset(demand_.position);
  enabled_ = on;
}

MotionFault Motion::add(const Move& move) noexcept {
  if (fault_ != MotionFault::kNone) return fault_;
  if (!enabled_) {
    fail(MotionFault::kDisabled);
  } else if (const MotionFault fault = check(move); fault != MotionFault::kNone) {
    fail(fault);
  } else if (!queue_.push(move)) {
    fail(MotionFault::kQueueOverflow);
  }
  return fault_;
}

void Motion::halt(bool on) noexcept {
  if (on && phase_ == Phase::kDiscrete) {
    const GeneratorLimits limits = limits_of(move_);
    brake(limits.deceleration, limits.jerk_time_s, Phase::kHalt);
  } else if (on && phase_ == Phase::kSegment) {
    brake(braking(move_.deceleration > 0 ? move_.deceleration : fault_deceleration_), 0.0, Phase::kHalt);
  }
  halted_ = on;
}

void Motion::stop(std::int32_t deceleration) noexcept {
  queue_.clear();
  if (moving()) brake(braking(deceleration), 0.0, Phase::kStop);
}

void Motion::mark(double position) noexcept {
  if (marked_ || !move_.beyond_mark || is_segment(move_.type)) return;
  if (phase_ != Phase::kDiscrete && phase_ != Phase::kHalt) return;
  marked_ = true;
  target_ = position + *move_.beyond_mark;
  if (phase_ == Phase::kDiscrete) generator_.move_to(target_, limits_of(move_));
}

void Motion::brake(double deceleration, double jerk_time_s, Phase phase) noexcept {
  if (phase_ == Phase::kSegment) generator_.reset(demand_);
  generator_.run_at(0.0, {1.0, deceleration, deceleration, jerk_time_s});
  phase_ = phase;
}

void Motion::fail(MotionFault fault) noexcept {
  fault_ = fault;
  stop(fault_deceleration_);
}

void Motion::take_next() noexcept {
  move_ = queue_.front();
  queue_.pop();
  marked_ = false;
}

void Motion::begin_discrete() noexcept {
  target_ = move_.target + (move_.relative ? demand_.position : 0.0);
  generator_.reset({demand_.position, 0.0, 0.0});
  generator_.move_to(target_, limits_of(move_));
  phase_ = Phase::kDiscrete;
}

/// Begins the segment in move_; returns false, with the fault set, if no motion leads to its end.
bool Motion::begin_segment(const ProfileState& start) noexcept {
  target_ = move_.target + (move_.relative ? start.position : 0.0);
  const MotionFault fault = segment_.plan(start, target_, move_);
  if (fault == MotionFault::kNone) {
    phase_ = Phase::kSegment;
    return true;
  }
  fail(fault);
  return false;
}

void Motion::run_segment(double period_s) noexcept {
  elapsed_s_ += period_s;
  while (elapsed_s_ >= segment_.duration_s()) {
    elapsed_s_ -= segment_.duration_s();
    demand_ = segment_.end();
    const bool stands = !(demand_.velocity < 0.0 || demand_.velocity > 0.0);
    if (stands) {
      phase_ = Phase::kIdle;
      return;
    }
    if (queue_.empty() || !is_segment(queue_.front().type)) return fail(MotionFault::kQueueUnderflow);
    take_next();
    if (!begin_segment(demand_)) return;
  }
  demand_ = segment_.at(elapsed_s_);
}

/// Goes on after a halt, from standstill. A segment whose end was passed while the axis braked has ended.
void Motion::resume() noexcept {
  if (!is_segment(move_.type)) {
    generator_.move_to(target_, limits_of(move_));
    phase_ = Phase::kDiscrete;
    return;
  }
  phase_ = Phase::kIdle;
  const double way = segment_.end().position - segment_.at(0.0).position;
  if ((target_ - demand_.position) * way <= 0.0) return;
  elapsed_s_ = 0.0;
  if (const MotionFault fault = segment_.plan(demand_, target_, move_); fault != MotionFault::kNone) return fail(fault);
  phase_ = Phase::kSegment;
}

void Motion::step(std::chrono::nanoseconds period) noexcept {
  const double period_s = std::chrono::duration<double>(period).count();
  if (phase_ == Phase::kHalt && generator_.finished() && !halted_) resume();
  if (phase_ == Phase::kIdle && !suspended_ && !halted_ && !queue_.empty()) {
    take_next();
    elapsed_s_ = 0.0;
    if (!is_segment(move_.type)) {
      begin_discrete();
    } else if (!begin_segment({demand_.position, 0.0, 0.0})) {
      return;
    }
  }
  if (phase_ == Phase::kIdle) return;
  if (phase_ == Phase::kSegment) return run_segment(period_s);
  generator_.step(period_s);
  demand_ = generator_.state();
  if (generator_.finished() && phase_ != Phase::kHalt) phase_ = Phase::kIdle;
}

}  // namespace driveline::slaves::position_servo
