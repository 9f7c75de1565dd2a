#include "driveline/motion/axis/mode_change.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace driveline::motion {
namespace {

using cia402::Mode;

/// Exchanges in a row that must show the wanted mode; by then a command to change back has reached the drive.
constexpr std::uint32_t kExchangesShown = 8;
/// Weight of a new measurement in the filtered torque.
constexpr double kFollowed = 1.0 / 4.0;
/// Cycles until the estimate of ObservedMotion is good. CST needs more cycles, because a torque may accelerate the axis
/// in any way.
constexpr std::uint32_t kCyclesObserved = 8;
constexpr std::uint32_t kCyclesObservedInTorque = 32;
/// Additional cycles for which the command to change is delayed while the axis does not yet move as commanded: its
/// acceleration has just changed, and the drive would take over a motion that is about to change.
constexpr std::uint32_t kCyclesUnsettled = 240;
/// Share of max_acceleration by which the actual acceleration may differ from the wanted one, and the time in s over
/// which that difference gives the permitted velocity lag.
constexpr double kSettledShare = 0.25;
constexpr double kSettledS = 1e-3;
/// Time-out for a drive to confirm a mode, s.
constexpr double kTimeoutS = 0.25;
/// Time within which a drive that changes immediately has confirmed, s.
constexpr double kAnswersS = 1e-3;
/// Fraction of the velocity error that the first position setpoint absorbs.
constexpr double kLagTaken = 0.5;
/// Share of its error by which the feed-forward velocity is corrected per cycle.
constexpr double kFed = 0.05;
/// Remaining error of the feed-forward velocity that is negligible, as a share of max_velocity.
constexpr double kFedWell = 1e-5;
/// Time constant with which the torque taken over from the drive fades to that of the master's loops, s.
constexpr double kFadeS = 0.2;

}  // namespace

void ModeChange::begin(const Measured& measured, const Targets& last) noexcept {
  elapsed_s_ = 0.0;
  shown_ = 0;
  if (phase_ == Phase::kPending) return;
  from_ = measured.shown;
  const bool by_position = cia402::by_position(from_);
  const bool by_torque = from_ == Mode::kCyclicTorque;
  const bool on_loop = by_torque || from_ == Mode::kCyclicVelocity;
  if (phase_ == Phase::kNone) {
    on_setpoints_ = by_position || on_loop;
    torque_bias_ = 0.0;
  }
  // Outside CST the torque target held the feed-forward only.
  if (!by_torque && measured.torque_known) torque_bias_ = measured.torque - last.torque;
  target_.position = last.position;
  const double velocity = by_position ? measured.led_velocity : on_loop ? last.velocity : measured.velocity;
  preparing_ = kCyclesUnsettled + (by_torque ? kCyclesObservedInTorque : kCyclesObserved);
  observed_.start({measured.position, by_position ? measured.led_velocity : measured.velocity, last.acceleration},
                  last.torque);
  // The position measured in this cycle is processed once more in the same cycle.
  if (measured.fresh) observed_.step_back();
  feed_velocity_ = last.feed_velocity;
  lag_ = {.before = {velocity, velocity}};
  leading_ = by_position;
  if (!on_loop && !by_position) return_from(measured.position - velocity * settings_.period_s, velocity);
  first_ = true;
  heard_ = false;
  held_ = {velocity, velocity, velocity};
  phase_ = Phase::kPending;
}

bool ModeChange::committed() const noexcept {
  return pending() && preparing_ == 0 && (shown_ > 0 || elapsed_s_ < kTimeoutS);
}

cia402::Mode ModeChange::in_force(Mode wanted) const noexcept {
  if (preparing_ > 0 || (shown_ == 0 && !heard_)) return from_;
  return shown_ > 0 || elapsed_s_ < kAnswersS ? wanted : from_;
}

/// In CST the motion continues with the acceleration by all commanded torques, in any other mode at its velocity.
void ModeChange::skip(std::int64_t periods, Mode wanted) noexcept {
  if (periods <= 0) return;
  const double time = static_cast<double>(periods) * settings_.period_s;
  if (in_force(wanted) == Mode::kCyclicTorque) {
    observed_.hold_torque();
  } else {
    observed_.coast();
  }
  observed_.pass(time);
  // A drive that may have received the command to change holds the velocity that came with it.
  const bool may_hold = preparing_ == 0 && elapsed_s_ > 0.0 && !heard_ && wanted == Mode::kCyclicVelocity;
  if (!may_hold) {
    held_.lowest += time * observed_.motion().acceleration;
    held_.highest += time * observed_.motion().acceleration;
  }
  // The velocity target of the last cycle was not sent.
  held_.target = held_.lowest;
  led_.position += time * led_.velocity;
  // A drive that follows positions has kept moving as well.
  target_.position += time * target_.velocity;
  if (!on_setpoints_) return_.skip(time);
  // The command was not sent, or may not have arrived: the drive would start at a position that was never measured. A
  // drive that received it without its answer arriving returns from CSP to CSV at the velocity that it has.
  const bool to_position = from_ == Mode::kCyclicVelocity && cia402::by_position(wanted);
  const bool unheard = !(elapsed_s_ > 0.0) || (to_position && !heard_);
  if (pending() && preparing_ == 0 && shown_ == 0 && unheard) preparing_ = kCyclesUnsettled;
}

void ModeChange::update(const Measured& measured, Mode wanted) noexcept {
  if (phase_ != Phase::kPending) return;
  heard_ = preparing_ == 0 && (heard_ || measured.fresh);
  if (measured.shown != wanted) {
    shown_ = 0;
  } else if (measured.fresh && ++shown_ >= kExchangesShown) {
    settle(measured, wanted);
  }
}

/// Ends the pending phase; the axis continues from the present motion of the drive.
void ModeChange::settle(const Measured& measured, Mode mode) noexcept {
  if (cia402::by_position(mode)) {
    return_from(target_.position, target_.velocity);
  } else if (mode == Mode::kCyclicVelocity && std::abs(lag_.bias) > 0.0) {
    return_from(measured.position - held_.target * settings_.period_s, held_.target);
  }
  if (mode != Mode::kCyclicTorque) torque_bias_ = 0.0;
  leading_ = false;
  phase_ = cyclic(mode) || cia402::by_position(mode) ? Phase::kReturning : Phase::kNone;
}

trajectory::AxisSetpoint ModeChange::reference(const Measured& measured,
                                               const trajectory::AxisSetpoint& setpoint) noexcept {
  trajectory::AxisSetpoint reference;
  if (led(measured)) {
    reference = lead(measured, setpoint);
  } else {
    // The loops of the master start at the actual position, not at the setpoint, which is ahead of it.
    if (std::exchange(leading_, false)) return_from(led_.position, led_.velocity);
    reference = on_setpoints_ ? setpoint : approach(setpoint);
  }
  reference_position_ = reference.position;
  feed(measured, reference);
  if (phase_ == Phase::kReturning) fade();
  return reference;
}

/// A drive applies a feed-forward velocity at once and a position only later. So while the drive may enter CSP, the
/// feed-forward is the velocity of the axis and not yet that of the reference.
void ModeChange::feed(const Measured& measured, const trajectory::AxisSetpoint& reference) noexcept {
  const bool by_setpoints = led(measured);
  const bool by_loop = pending() && !cia402::by_position(measured.shown);
  const double wanted = by_setpoints ? target_.velocity : by_loop ? observed_.motion().velocity : reference.velocity;
  const double acceleration = by_setpoints ? target_.acceleration : reference.acceleration;
  feed_velocity_ += settings_.period_s * acceleration + kFed * (wanted - feed_velocity_);
  fed_ = std::abs(reference.velocity - feed_velocity_) <= kFedWell * settings_.limits.max_velocity;
}

/// While the drive still follows positions, it keeps getting its regular position setpoints; the resulting motion is
/// the reference for the loops of the master.
trajectory::AxisSetpoint ModeChange::lead(const Measured& measured, const trajectory::AxisSetpoint& setpoint) noexcept {
  // After missed cycles the two velocities do not belong to one motion, so limit the acceleration.
  const double most = settings_.limits.max_acceleration;
  const double change = (measured.led_velocity - led_.velocity) / settings_.period_s;
  const double acceleration = first_ ? 0.0 : std::clamp(change, -most, most);
  target_ = on_setpoints_ ? setpoint : approach(setpoint);
  const bool seen = first_ || measured.fresh;
  const double position = seen ? measured.position : led_.position + measured.led_velocity * settings_.period_s;
  led_ = {position, measured.led_velocity, acceleration, setpoint.torque};
  return led_;
}

void ModeChange::return_from(double position, double velocity) noexcept {
  return_ = {position, velocity, settings_.limits};
  on_setpoints_ = false;
}

/// Reduces the deviation from the setpoints to zero with the part of the limits that the motion leaves.
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

void ModeChange::follow(const Measured& measured, const Wanted& wanted) noexcept {
  const bool by_torque = measured.shown == Mode::kCyclicTorque;
  if (by_torque) observed_.command(wanted.torque + torque_bias_);
  observed_.predict();
  if (measured.fresh) observed_.correct(measured.position);
  held_.lowest = measured.fresh ? held_.target : std::min(held_.lowest, held_.target);
  held_.highest = measured.fresh ? held_.target : std::max(held_.highest, held_.target);
  const auto& motion = observed_.motion();
  if (by_torque) lag_.bias = motion.velocity - lag_.before[1];
  if (measured.shown == Mode::kCyclicVelocity) lag_.lag = motion.velocity - lag_.before[1] - lag_.bias;
  lag_.before[1] = lag_.before[0];
  lag_.before[0] = wanted.velocity;
  // The bias is the torque beyond what accelerates the axis as it was observed to accelerate.
  const double accelerates = settings_.inertia * (wanted.acceleration - motion.acceleration);
  if (!by_torque && measured.fresh && measured.torque_known)
    torque_bias_ += kFollowed * (measured.torque - wanted.torque + accelerates - torque_bias_);
  const double demand = gradually(wanted.velocity + lag_.bias);
  if (!led(measured)) place(cia402::by_position(measured.shown), demand);
  held_.target = demand;
  if (preparing_ > 0) {
    if (preparing_ > 1 || measured.fresh) --preparing_;
    const double most = kSettledShare * settings_.limits.max_acceleration;
    const bool settled = std::abs(lag_.lag) <= kSettledS * most && measured.fresh &&
                         std::abs(wanted.acceleration - motion.acceleration) <= most;
    elapsed_s_ = settled ? elapsed_s_ + settings_.period_s : 0.0;
    const bool long_enough = elapsed_s_ > (kCyclesObserved - 0.5) * settings_.period_s;
    if (preparing_ <= kCyclesUnsettled && long_enough) preparing_ = 0;
    if (preparing_ == 0) elapsed_s_ = 0.0;
  } else {
    elapsed_s_ += settings_.period_s;
  }
  first_ = false;
}

/// Limits the step of the velocity target. A drive in CSV has held one of the last targets during a gap, and it is not
/// known which. A drive that has not been commanded into CSV yet holds none.
double ModeChange::gradually(double velocity) const noexcept {
  if (first_ || (preparing_ > 0 && from_ != Mode::kCyclicVelocity)) return velocity;
  const double most = settings_.limits.max_acceleration * settings_.period_s;
  return std::min(std::max(velocity, held_.highest - most), held_.lowest + most);
}

/// Position target that yields the motion of this velocity. A position takes effect half a cycle later than a velocity.
void ModeChange::place(bool by_position, double velocity) noexcept {
  if (by_position) {
    target_.velocity = velocity + kLagTaken * lag_.lag + 0.5 * (velocity - held_.target);
    target_.position += settings_.period_s * target_.velocity;
    return;
  }
  const double ahead = settings_.lead_cycles * settings_.period_s;
  const auto& motion = observed_.motion();
  target_.position = motion.position + ahead * (motion.velocity + 0.5 * ahead * observed_.coming_acceleration());
  target_.velocity = velocity;
}

}  // namespace driveline::motion
