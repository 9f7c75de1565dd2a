#include "driveline/ecat_master/cyclic/setpoint_supply.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace driveline::ecat_master {
namespace {

/// Number of missing setpoint periods that drives bridge at their last velocity.
constexpr std::uint32_t kBridgedPeriods = 8;

bool by_positions(cia402::Mode mode) noexcept {
  return mode == cia402::Mode::kCyclicPosition || mode == cia402::Mode::kInterpolatedPosition;
}

/// In CSV and CST a drive without new setpoints does not slow down: it holds its velocity, or its torque.
trajectory::Coast coast_of(cia402::Mode mode, double max_acceleration) noexcept {
  constexpr auto kForGood = std::numeric_limits<std::uint32_t>::max();
  if (!by_positions(mode)) return {kForGood, 0.0};
  return {kBridgedPeriods, max_acceleration};
}

}  // namespace

SetpointSupply::SetpointSupply(const AxisConfig& axis, double period_s)
    : mode_(axis.mode),
      coast_(coast_of(axis.mode, axis.limits.max_acceleration)),
      max_velocity_(axis.limits.max_velocity),
      max_acceleration_(axis.limits.max_acceleration),
      period_s_(period_s) {}

void SetpointSupply::set_mode(cia402::Mode mode) noexcept {
  mode_ = mode;
  coast_ = coast_of(mode, max_acceleration_);
  coast_.give(sent_, sent_velocity_, held_acceleration());
}

void SetpointSupply::note(const trajectory::AxisSetpoint& sent, cia402::Mode mode) noexcept {
  if (mode != mode_) set_mode(mode);
  // A drive that holds its velocity was commanded that velocity, wherever the previous setpoint was.
  sent_velocity_ = by_positions(mode_) ? (sent.position - sent_) / period_s_ : sent.velocity;
  sent_ = sent.position;
  sent_acceleration_ = sent.acceleration;
  if (reached_) {
    coast_.give(sent_, sent_velocity_, held_acceleration());
  } else {
    coast_.step(period_s_);
  }
}

void SetpointSupply::start_from(const trajectory::AxisSetpoint& from) noexcept {
  sent_ = from.position;
  sent_velocity_ = from.velocity;
  sent_acceleration_ = from.acceleration;
  coast_.give(sent_, sent_velocity_, held_acceleration());
}

void SetpointSupply::skip(std::int64_t missed, cia402::Mode mode) noexcept {
  if (mode != mode_) set_mode(mode);
  for (std::int64_t period = 0; period < missed; ++period) coast_.step(period_s_);
  sent_ = coast_.position();
  sent_velocity_ = coast_.velocity();
}

trajectory::AxisSetpoint SetpointSupply::bridge() const noexcept {
  const double most = max_acceleration_ * period_s_;
  const double top = std::max(max_velocity_, std::abs(sent_velocity_));
  const double step = by_positions(mode_) ? (coast_.next(period_s_).position - sent_) / period_s_
                                          : sent_velocity_ + held_acceleration() * period_s_;
  const double velocity = std::clamp(step, std::max(sent_velocity_ - most, -top), std::min(sent_velocity_ + most, top));
  const double acceleration = by_torque() ? (velocity - sent_velocity_) / period_s_ : 0.0;
  return {sent_ + velocity * period_s_, velocity, acceleration};
}

/// Acceleration that results from a held torque.
double SetpointSupply::held_acceleration() const noexcept {
  return by_torque() ? std::clamp(sent_acceleration_, -max_acceleration_, max_acceleration_) : 0.0;
}

}  // namespace driveline::ecat_master
