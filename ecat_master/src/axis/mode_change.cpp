#include "driveline/ecat_master/axis/mode_change.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/trajectory/rejoin.hpp"

namespace driveline::ecat_master {
namespace {

using cia402::Mode;

/// Exchanges in which a drive must have shown its mode, so that one that was told to go back has heard of it.
constexpr std::uint32_t kExchangesShown = 8;
/// Share of a new measurement in what is followed: positions and torques come in steps, and later than the targets.
constexpr double kFollowed = 1.0 / 64.0;
/// The same of a position and the velocity seen in it, in a filter whose memory fades by 0.85 in each cycle, and the
/// cycles until that is known well.
constexpr double kObservedPosition = 1.0 - 0.85 * 0.85;
constexpr double kObservedVelocity = 0.15 * 0.15;
constexpr std::uint32_t kCyclesObserved = 32;
/// Shares of the limits for the return to the setpoints.
constexpr double kLeastShare = 0.05;
constexpr double kMostShare = 0.1;
/// Time in which the torque that was taken over from the drive goes back to what the loops of the master want.
constexpr double kFadeS = 0.2;

}  // namespace

void ModeChange::begin(const Measured& measured, const Targets& last) noexcept {
  if (phase_ == Phase::kPending) return;
  from_ = measured.shown;
  const bool by_position = from_ == Mode::kCyclicPosition;
  const bool by_torque = from_ == Mode::kCyclicTorque;
  const bool on_loop = by_torque || from_ == Mode::kCyclicVelocity;
  if (phase_ == Phase::kNone) {
    on_setpoints_ = on_loop;
    torque_bias_ = 0.0;
  }
  // The target was the feed-forward alone.
  if (!by_torque && measured.torque_known) torque_bias_ = measured.torque - last.torque;
  position_ = last.position;
  velocity_ = by_position ? measured.led_velocity : on_loop ? last.velocity : measured.velocity;
  preparing_ = by_torque ? kCyclesObserved : 0;
  // The loops of the master begin where the axis is, and not where its setpoints are already.
  if (!on_loop) return_from(measured.position - velocity_ * settings_.period_s, velocity_);
  velocity_bias_ = 0.0;
  observing_ = false;
  first_ = true;
  shown_ = 0;
  phase_ = Phase::kPending;
}

void ModeChange::look(const Measured& measured, Mode wanted) noexcept {
  if (phase_ != Phase::kPending) return;
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
  phase_ = cyclic(mode) ? Phase::kReturning : Phase::kNone;
}

trajectory::AxisSetpoint ModeChange::reference(const Measured& measured,
                                               const trajectory::AxisSetpoint& setpoint) noexcept {
  auto reference = setpoint;
  if (led(measured)) {
    // As long as the drive follows positions it gets those that it always got, and leads the loops of the master.
    const double acceleration = (measured.led_velocity - velocity_) / settings_.period_s;
    reference = {measured.position, measured.led_velocity, first_ ? 0.0 : acceleration, setpoint.torque};
    return_from(measured.position, measured.led_velocity);
    position_ = setpoint.position;
    position_velocity_ = setpoint.velocity;
  } else if (!on_setpoints_) {
    reference = approach(setpoint);
  }
  reference_position_ = reference.position;
  if (phase_ == Phase::kReturning) fade();
  return reference;
}

void ModeChange::return_from(double position, double velocity) noexcept {
  start_ = {position, velocity, 0.0};
  started_ = true;
  on_setpoints_ = false;
}

/// The deviation from the setpoints goes to zero with what the motion leaves of the limits.
trajectory::AxisSetpoint ModeChange::approach(const trajectory::AxisSetpoint& setpoint) noexcept {
  if (started_) {
    const double before = setpoint.position - setpoint.velocity * settings_.period_s;
    deviation_ = start_.position - before;
    deviation_velocity_ = start_.velocity - setpoint.velocity;
    started_ = false;
  }
  const auto& limits = settings_.limits;
  const trajectory::AxisLimits spare{
      std::max(limits.max_velocity - std::abs(setpoint.velocity), kLeastShare * limits.max_velocity),
      std::clamp(limits.max_acceleration - std::abs(setpoint.acceleration), kLeastShare * limits.max_acceleration,
                 kMostShare * limits.max_acceleration)};
  trajectory::Rejoin way(deviation_, deviation_velocity_, spare);
  const auto deviation = way.step({}, settings_.period_s);
  deviation_ = deviation.position;
  deviation_velocity_ = deviation.velocity;
  on_setpoints_ = way.joined();
  return {setpoint.position + deviation.position, setpoint.velocity + deviation.velocity,
          setpoint.acceleration + deviation.acceleration, setpoint.torque};
}

void ModeChange::fade() noexcept {
  torque_bias_ -= torque_bias_ * settings_.period_s / kFadeS;
  if (std::abs(torque_bias_) < settings_.least_torque) torque_bias_ = 0.0;
  if (on_setpoints_ && !(std::abs(torque_bias_) > 0.0)) phase_ = Phase::kNone;
}

/// What is between the velocity that was wanted two cycles before and that of the axis: a load, or a loop, moves it,
/// and the measured velocity is filtered.
void ModeChange::observe(const Measured& measured, double velocity) noexcept {
  if (!observing_) {
    observing_ = true;
    observed_ = measured.position;
    observed_bias_ = measured.shown == Mode::kCyclicTorque ? measured.velocity - velocity : 0.0;
    before_[0] = before_[1] = velocity;
    return;
  }
  observed_ += (before_[1] + observed_bias_) * settings_.period_s;
  before_[1] = before_[0];
  before_[0] = velocity;
  if (!measured.fresh) return;
  const double deviation = measured.position - observed_;
  observed_ += kObservedPosition * deviation;
  observed_bias_ += kObservedVelocity * deviation / settings_.period_s;
}

void ModeChange::follow(const Measured& measured, double velocity, double torque) noexcept {
  const bool by_torque = measured.shown == Mode::kCyclicTorque;
  const bool by_position = measured.shown == Mode::kCyclicPosition;
  if (by_position) {
    observing_ = false;
  } else {
    observe(measured, by_torque ? velocity : velocity + velocity_bias_);
  }
  if (by_torque && from_ == Mode::kCyclicTorque) velocity_bias_ = observed_bias_;
  if (!by_torque && measured.fresh && measured.torque_known)
    torque_bias_ += kFollowed * (measured.torque - torque - torque_bias_);
  const double demand = velocity + velocity_bias_;
  if (!led(measured)) place(by_position, demand);
  velocity_ = demand;
  if (preparing_ > 0) --preparing_;
  first_ = false;
}

/// The position that leads to the motion of this velocity. The drive takes half a cycle more for a position than for a
/// velocity.
void ModeChange::place(bool by_position, double velocity) noexcept {
  const double half_rise = first_ ? 0.0 : 0.5 * (velocity - velocity_);
  if (by_position) {
    position_velocity_ = velocity + half_rise;
    position_ += settings_.period_s * position_velocity_;
    return;
  }
  const double actual = before_[0] + observed_bias_ - half_rise;
  position_ = observed_ + settings_.lead_cycles * settings_.period_s * actual;
  position_velocity_ = velocity;
}

}  // namespace driveline::ecat_master
