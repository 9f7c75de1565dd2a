#include "driveline/ecat_master/axis/mode_change.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace driveline::ecat_master {
namespace {

using cia402::Mode;

/// Exchanges in which a drive must have shown its mode, so that one that was told to go back has heard of it.
constexpr std::uint32_t kExchangesShown = 8;
/// Share of a new measurement in the torque that is followed.
constexpr double kFollowed = 1.0 / 4.0;
/// The same of a position, and of velocity and acceleration seen in it, in a filter whose memory fades in each cycle,
/// and the cycles until they are known well; by its torque an axis may do anything.
constexpr double kMemory = 0.75;
constexpr double kObservedPosition = 1.0 - kMemory * kMemory * kMemory;
constexpr double kObservedVelocity = 1.5 * (1.0 - kMemory) * (1.0 - kMemory) * (1.0 + kMemory);
constexpr double kObservedAcceleration = (1.0 - kMemory) * (1.0 - kMemory) * (1.0 - kMemory);
constexpr std::uint32_t kCyclesObserved = 8;
constexpr std::uint32_t kCyclesObservedInTorque = 32;
/// How many cycles longer a drive is not told while the axis does not do yet what it was told last: its acceleration
/// has just changed, and its drive would take over from a motion that is about to be another one.
constexpr std::uint32_t kCyclesUnsettled = 240;
/// Of the highest acceleration: what the axis may have of another one than wanted; and the time in which that makes the
/// velocity that it may lack.
constexpr double kSettledShare = 0.25;
constexpr double kSettledS = 1e-3;
/// In which a drive changes that is going to.
constexpr double kPatienceS = 0.25;
/// In which a drive that changes at once has done so.
constexpr double kAnswersS = 1e-3;
/// Of a velocity that the axis lacks, the share that position setpoints begin without: the demand and the axis meet.
constexpr double kLagTaken = 0.5;
/// Share by which the feed-forward of the velocity approaches what it should be.
constexpr double kFed = 0.05;
/// When it is there, in shares of the highest velocity.
constexpr double kFedWell = 1e-5;
/// Time in which the torque that was taken over from the drive goes back to what the loops of the master want.
constexpr double kFadeS = 0.2;
/// Shares of the change of a torque that have come into effect in the three cycles after it was told.
constexpr double kTorqueArrives[] = {0.3, 0.4, 0.3};

}  // namespace

void ModeChange::begin(const Measured& measured, const Targets& last) noexcept {
  told_s_ = 0.0;
  shown_ = 0;
  if (phase_ == Phase::kPending) return;
  from_ = measured.shown;
  const bool by_position = from_ == Mode::kCyclicPosition;
  const bool by_torque = from_ == Mode::kCyclicTorque;
  const bool on_loop = by_torque || from_ == Mode::kCyclicVelocity;
  if (phase_ == Phase::kNone) {
    on_setpoints_ = by_position || on_loop;
    torque_bias_ = 0.0;
  }
  // The target was the feed-forward alone.
  if (!by_torque && measured.torque_known) torque_bias_ = measured.torque - last.torque;
  position_ = last.position;
  velocity_ = by_position ? measured.led_velocity : on_loop ? last.velocity : measured.velocity;
  preparing_ = kCyclesUnsettled + (by_torque ? kCyclesObservedInTorque : kCyclesObserved);
  observed_ = {measured.position, by_position ? measured.led_velocity : measured.velocity, last.acceleration};
  // The measured position of a cycle is looked at in the same cycle once more.
  if (measured.fresh) observed_.position -= observed_.velocity * settings_.period_s;
  feed_velocity_ = last.feed_velocity;
  before_[0] = before_[1] = velocity_;
  std::fill(std::begin(told_torque_), std::end(told_torque_), last.torque);
  on_its_way_ = 0.0;
  leading_ = by_position;
  if (!on_loop && !by_position) return_from(measured.position - velocity_ * settings_.period_s, velocity_);
  velocity_bias_ = 0.0;
  lag_ = 0.0;
  first_ = true;
  heard_ = false;
  lowest_held_ = highest_held_ = velocity_;
  phase_ = Phase::kPending;
}

bool ModeChange::committed() const noexcept {
  return pending() && preparing_ == 0 && (shown_ > 0 || told_s_ < kPatienceS);
}

cia402::Mode ModeChange::in_force(Mode wanted) const noexcept {
  if (preparing_ > 0 || (shown_ == 0 && !heard_)) return from_;
  return shown_ > 0 || told_s_ < kAnswersS ? wanted : from_;
}

/// A drive that holds its torque goes on as all that it was told accelerates it, any other one at its velocity.
void ModeChange::skip(std::int64_t periods, Mode wanted) noexcept {
  if (periods <= 0) return;
  const double time = static_cast<double>(periods) * settings_.period_s;
  if (in_force(wanted) == Mode::kCyclicTorque) {
    hold_torque();
  } else {
    observed_.acceleration = 0.0;
  }
  observed_.position += time * (observed_.velocity + 0.5 * time * observed_.acceleration);
  observed_.velocity += time * observed_.acceleration;
  // One that was told, and may have heard it, holds the velocity that it got with that.
  const bool may_hold = preparing_ == 0 && told_s_ > 0.0 && !heard_ && wanted == Mode::kCyclicVelocity;
  if (!may_hold) {
    lowest_held_ += time * observed_.acceleration;
    highest_held_ += time * observed_.acceleration;
  }
  // The one of the last cycle has not been sent.
  velocity_ = lowest_held_;
  led_.position += time * led_.velocity;
  // A drive that follows positions has gone on as well.
  position_ += time * position_velocity_;
  if (!on_setpoints_) return_.skip(time);
  // What was told last has not been sent, or may not have arrived: its drive would begin with a place that nobody has
  // seen. One that has heard it, and not been heard, goes back from CSP to CSV with the velocity that it has.
  const bool to_position = from_ == Mode::kCyclicVelocity && wanted == Mode::kCyclicPosition;
  const bool unheard = !(told_s_ > 0.0) || (to_position && !heard_);
  if (pending() && preparing_ == 0 && shown_ == 0 && unheard) preparing_ = kCyclesUnsettled;
}

void ModeChange::look(const Measured& measured, Mode wanted) noexcept {
  if (phase_ != Phase::kPending) return;
  heard_ = preparing_ == 0 && (heard_ || measured.fresh);
  if (measured.shown != wanted) {
    shown_ = 0;
  } else if (measured.fresh && ++shown_ >= kExchangesShown) {
    settle(measured, wanted);
  }
}

/// The axis goes on from what the drive does now.
void ModeChange::settle(const Measured& measured, Mode mode) noexcept {
  if (mode == Mode::kCyclicPosition) {
    return_from(position_, position_velocity_);
  } else if (mode == Mode::kCyclicVelocity && std::abs(velocity_bias_) > 0.0) {
    return_from(measured.position - velocity_ * settings_.period_s, velocity_);
  }
  if (mode != Mode::kCyclicTorque) torque_bias_ = 0.0;
  leading_ = false;
  phase_ = cyclic(mode) ? Phase::kReturning : Phase::kNone;
}

trajectory::AxisSetpoint ModeChange::reference(const Measured& measured,
                                               const trajectory::AxisSetpoint& setpoint) noexcept {
  trajectory::AxisSetpoint reference;
  if (led(measured)) {
    reference = lead(measured, setpoint);
  } else {
    // The loops of the master begin where the axis is, and not where its setpoints are already.
    if (std::exchange(leading_, false)) return_from(led_.position, led_.velocity);
    reference = on_setpoints_ ? setpoint : approach(setpoint);
  }
  reference_position_ = reference.position;
  feed(measured, reference);
  if (phase_ == Phase::kReturning) fade();
  return reference;
}

/// A drive takes the velocity of the feed-forward at once and a position later: where it may get into CSP, that is the
/// velocity of the axis, and not yet that of the reference.
void ModeChange::feed(const Measured& measured, const trajectory::AxisSetpoint& reference) noexcept {
  const bool by_setpoints = led(measured);
  const bool by_loop = pending() && measured.shown != Mode::kCyclicPosition;
  const double wanted = by_setpoints ? position_velocity_ : by_loop ? observed_.velocity : reference.velocity;
  const double acceleration = by_setpoints ? position_acceleration_ : reference.acceleration;
  feed_velocity_ += settings_.period_s * acceleration + kFed * (wanted - feed_velocity_);
  fed_ = std::abs(reference.velocity - feed_velocity_) <= kFedWell * settings_.limits.max_velocity;
}

/// As long as the drive follows positions it goes on with those that it would get anyway, and leads the loops of the
/// master.
trajectory::AxisSetpoint ModeChange::lead(const Measured& measured, const trajectory::AxisSetpoint& setpoint) noexcept {
  // Behind a gap the velocities of two cycles are not those of one motion.
  const double most = settings_.limits.max_acceleration;
  const double change = (measured.led_velocity - led_.velocity) / settings_.period_s;
  const double acceleration = first_ ? 0.0 : std::clamp(change, -most, most);
  const auto target = on_setpoints_ ? setpoint : approach(setpoint);
  position_ = target.position;
  position_velocity_ = target.velocity;
  position_acceleration_ = target.acceleration;
  const bool seen = first_ || measured.fresh;
  const double position = seen ? measured.position : led_.position + measured.led_velocity * settings_.period_s;
  led_ = {position, measured.led_velocity, acceleration, setpoint.torque};
  return led_;
}

void ModeChange::return_from(double position, double velocity) noexcept {
  return_ = {position, velocity, settings_.limits};
  on_setpoints_ = false;
}

/// The deviation from the setpoints goes to zero with what the motion leaves of the limits.
trajectory::AxisSetpoint ModeChange::approach(const trajectory::AxisSetpoint& setpoint) noexcept {
  const auto reference = return_.step(setpoint, settings_.period_s);
  on_setpoints_ = return_.joined();
  return reference;
}

void ModeChange::fade() noexcept {
  torque_bias_ -= torque_bias_ * settings_.period_s / kFadeS;
  if (std::abs(torque_bias_) < settings_.least_torque) torque_bias_ = 0.0;
  if (on_setpoints_ && fed_ && !(std::abs(torque_bias_) > 0.0)) phase_ = Phase::kNone;
}

/// What the axis does, whatever its drive follows: a position comes in steps.
void ModeChange::observe(const Measured& measured) noexcept {
  const double t = settings_.period_s;
  observed_.position += t * (observed_.velocity + 0.5 * t * observed_.acceleration);
  observed_.velocity += t * observed_.acceleration;
  if (!measured.fresh) return;
  const double deviation = measured.position - observed_.position;
  observed_.position += kObservedPosition * deviation;
  observed_.velocity += kObservedVelocity * deviation / t;
  observed_.acceleration += kObservedAcceleration * deviation / (t * t);
}

/// By the torque that it was told in the last cycles the axis is going to accelerate otherwise than it was seen to.
void ModeChange::expect(double torque) noexcept {
  if (!(settings_.inertia > 0.0)) return;
  double arrives = 0.0;
  for (std::size_t i = 0; i < 3; ++i) arrives += kTorqueArrives[i] * (told_torque_[i] - told_torque_[i + 1]);
  observed_.acceleration += arrives / settings_.inertia;
  const double rest = kTorqueArrives[2] * (told_torque_[1] - told_torque_[2]) +
                      (1.0 - kTorqueArrives[0]) * (told_torque_[0] - told_torque_[1]);
  on_its_way_ = (torque - told_torque_[0] + rest) / settings_.inertia;
  std::copy_backward(std::begin(told_torque_), std::end(told_torque_) - 1, std::end(told_torque_));
  told_torque_[0] = torque;
}

/// The torque of the last cycle has not been sent; those before it come into effect.
void ModeChange::hold_torque() noexcept {
  if (!(settings_.inertia > 0.0)) return;
  const double arrives = (1.0 - kTorqueArrives[0]) * (told_torque_[1] - told_torque_[2]) +
                         kTorqueArrives[2] * (told_torque_[2] - told_torque_[3]);
  observed_.acceleration += arrives / settings_.inertia;
  on_its_way_ = 0.0;
  std::fill(std::begin(told_torque_), std::end(told_torque_), told_torque_[1]);
}

void ModeChange::follow(const Measured& measured, const Wanted& wanted) noexcept {
  const bool by_torque = measured.shown == Mode::kCyclicTorque;
  if (by_torque) expect(wanted.torque + torque_bias_);
  observe(measured);
  lowest_held_ = measured.fresh ? velocity_ : std::min(lowest_held_, velocity_);
  highest_held_ = measured.fresh ? velocity_ : std::max(highest_held_, velocity_);
  // Between the velocity that was wanted two cycles before and that of the axis: a load, or a loop, moves it.
  if (by_torque) velocity_bias_ = observed_.velocity - before_[1];
  if (measured.shown == Mode::kCyclicVelocity) lag_ = observed_.velocity - before_[1] - velocity_bias_;
  before_[1] = before_[0];
  before_[0] = wanted.velocity;
  // What the torque is beyond the one that moves the axis as it moves.
  const double accelerates = settings_.inertia * (wanted.acceleration - observed_.acceleration);
  if (!by_torque && measured.fresh && measured.torque_known)
    torque_bias_ += kFollowed * (measured.torque - wanted.torque + accelerates - torque_bias_);
  const double demand = gradually(wanted.velocity + velocity_bias_);
  if (!led(measured)) place(measured.shown == Mode::kCyclicPosition, demand);
  velocity_ = demand;
  if (preparing_ > 0) {
    if (preparing_ > 1 || measured.fresh) --preparing_;
    const double most = kSettledShare * settings_.limits.max_acceleration;
    const bool settled = std::abs(lag_) <= kSettledS * most && measured.fresh &&
                         std::abs(wanted.acceleration - observed_.acceleration) <= most;
    told_s_ = settled ? told_s_ + settings_.period_s : 0.0;
    const bool long_enough = told_s_ > (kCyclesObserved - 0.5) * settings_.period_s;
    if (preparing_ <= kCyclesUnsettled && long_enough) preparing_ = 0;
    if (preparing_ == 0) told_s_ = 0.0;
  } else {
    told_s_ += settings_.period_s;
  }
  first_ = false;
}

/// A drive in CSV has held its last velocity for as long as a gap, whichever that was. One that has not been told to
/// follow velocities yet has held none.
double ModeChange::gradually(double velocity) const noexcept {
  if (first_ || (preparing_ > 0 && from_ != Mode::kCyclicVelocity)) return velocity;
  const double most = settings_.limits.max_acceleration * settings_.period_s;
  return std::min(std::max(velocity, highest_held_ - most), lowest_held_ + most);
}

/// The position that leads to the motion of this velocity. The drive takes half a cycle more for a position than for a
/// velocity.
void ModeChange::place(bool by_position, double velocity) noexcept {
  if (by_position) {
    position_velocity_ = velocity + kLagTaken * lag_ + 0.5 * (velocity - velocity_);
    position_ += settings_.period_s * position_velocity_;
    return;
  }
  const double ahead = settings_.lead_cycles * settings_.period_s;
  const double acceleration = observed_.acceleration + on_its_way_;
  position_ = observed_.position + ahead * (observed_.velocity + 0.5 * ahead * acceleration);
  position_velocity_ = velocity;
}

}  // namespace driveline::ecat_master
