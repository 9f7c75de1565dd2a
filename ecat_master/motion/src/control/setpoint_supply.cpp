#include "driveline/motion/control/setpoint_supply.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace driveline::motion {
namespace {

/// Number of missing setpoints that drives bridge at their last velocity.
constexpr std::uint32_t kBridgedPeriods = 8;

/// In CSV and CST a drive without new setpoints does not slow down: it holds its velocity, or its torque.
trajectory::Coast coast_of(cia402::Mode mode, double max_acceleration, std::uint32_t divider) noexcept {
  constexpr auto kForGood = std::numeric_limits<std::uint32_t>::max();
  if (!cia402::by_position(mode)) return {kForGood, 0.0};
  return {kBridgedPeriods * divider, max_acceleration};
}

}  // namespace

SetpointSupply::SetpointSupply(const AxisConfig& axis, double period_s, std::uint32_t divider)
    : mode_(axis.mode),
      coast_(coast_of(axis.mode, axis.limits.max_acceleration, divider)),
      max_velocity_(axis.limits.max_velocity),
      max_acceleration_(axis.limits.max_acceleration),
      period_s_(period_s),
      certain_(axis.loss_is_certain && divider == 1),
      divider_(divider) {}

bool SetpointSupply::by_exchanges() const noexcept {
  return divider_ > 1 && cia402::by_position(mode_);
}

void SetpointSupply::set_mode(cia402::Mode mode) noexcept {
  mode_ = mode;
  coast_ = coast_of(mode, max_acceleration_, divider_);
  coast_.give(sent_, sent_velocity_, held_acceleration());
  before_ = coast_;
}

void SetpointSupply::note(const trajectory::AxisSetpoint& sent, cia402::Mode mode) noexcept {
  if (mode != mode_) set_mode(mode);
  if (certain_ && !reached_) return note_lost();
  lacking_ = 0;
  before_ = coast_;
  // A drive that holds its velocity was commanded that velocity, wherever the previous setpoint was.
  sent_velocity_ = cia402::by_position(mode_) ? (sent.position - sent_) / period_s_ : sent.velocity;
  sent_ = sent.position;
  sent_acceleration_ = sent.acceleration;
  if (divider_ > 1) note_exchange();
  if (reached_ && due_) {
    coast_.give(sent_, by_exchanges() ? offered_velocity_ : sent_velocity_, held_acceleration());
  } else {
    coast_.step(period_s_);
  }
}

/// The drive goes on without the setpoint, so that the next one continues from there: a step that also had to fit the
/// lost one would leave part of the way of the drive to be caught up with.
void SetpointSupply::note_lost() noexcept {
  ++lacking_;
  coast_.step(period_s_);
  sent_ = coast_.position();
  sent_velocity_ = coast_.velocity();
  sent_acceleration_ = held_acceleration();
}

/// Records the setpoint of an exchange: the only ones from which a drive takes its velocity.
void SetpointSupply::note_exchange() noexcept {
  ++since_;
  if (!due_) return;
  since_ = 0;
  offered_velocity_ = (sent_ - offered_) / (period_s_ * divider_);
  offered_ = sent_;
}

/// Sets the last exchange to what the drive has done according to the coast.
void SetpointSupply::expect_from_coast() noexcept {
  if (divider_ == 1) return;
  since_ %= divider_;
  offered_velocity_ = coast_.velocity();
  offered_ = coast_.position() - coast_.velocity() * period_s_ * since_;
}

void SetpointSupply::start_from(const trajectory::AxisSetpoint& from) noexcept {
  sent_ = from.position;
  sent_velocity_ = from.velocity;
  sent_acceleration_ = from.acceleration;
  coast_.give(sent_, sent_velocity_, held_acceleration());
  before_ = coast_;
  expect_from_coast();
}

void SetpointSupply::skip(std::int64_t missed, cia402::Mode mode) noexcept {
  if (mode != mode_) set_mode(mode);
  if (certain_ && reached_) {
    // The last setpoint has been sent, and waits for a SYNC that has not come.
    coast_ = before_;
    note_lost();
  }
  coast_.skip(missed, period_s_);
  lacking_ += missed;
  sent_ = coast_.position();
  sent_velocity_ = coast_.velocity();
  since_ += static_cast<std::uint32_t>(missed % divider_);
  expect_from_coast();
}

trajectory::AxisSetpoint SetpointSupply::bridge(std::uint32_t held_up) const noexcept {
  if (reached_ && held_up > kBridgedPeriods * divider_) return brake();
  if (by_exchanges()) return bridge_to_exchange();
  const double most = max_acceleration_ * period_s_;
  const double top = std::max(max_velocity_, std::abs(sent_velocity_));
  const double step = cia402::by_position(mode_) ? (coast_.next(period_s_).position - sent_) / period_s_
                                                 : sent_velocity_ + held_acceleration() * period_s_;
  const double velocity = std::clamp(step, std::max(sent_velocity_ - most, -top), std::min(sent_velocity_ + most, top));
  const double acceleration = by_torque() ? (velocity - sent_velocity_) / period_s_ : 0.0;
  return {sent_ + velocity * period_s_, velocity, acceleration};
}

/// Moves evenly to the setpoint of the next exchange, which the drive receives next.
trajectory::AxisSetpoint SetpointSupply::bridge_to_exchange() const noexcept {
  const auto left = divider_ - std::min(since_, divider_ - 1);
  auto later = coast_;
  later.skip(left, period_s_);
  const double most = max_acceleration_ * period_s_ * divider_;
  const double top = std::max(max_velocity_, std::abs(offered_velocity_));
  const double velocity = std::clamp((later.position() - sent_) / (left * period_s_),
                                     std::max(offered_velocity_ - most, -top), std::min(offered_velocity_ + most, top));
  return {sent_ + velocity * period_s_, velocity, 0.0};
}

/// Slows the axis down from the last setpoint, to rest.
trajectory::AxisSetpoint SetpointSupply::brake() const noexcept {
  const double change = std::min(std::abs(sent_velocity_), max_acceleration_ * period_s_);
  const double velocity = sent_velocity_ - std::copysign(change, sent_velocity_);
  const double acceleration = by_torque() ? (velocity - sent_velocity_) / period_s_ : 0.0;
  return {sent_ + velocity * period_s_, velocity, acceleration};
}

/// Acceleration that results from a held torque.
double SetpointSupply::held_acceleration() const noexcept {
  return by_torque() ? std::clamp(sent_acceleration_, -max_acceleration_, max_acceleration_) : 0.0;
}

}  // namespace driveline::motion
