#include "driveline/trajectory/position_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace driveline::trajectory {
namespace {

/// Time constants after which the unknown initial state has decayed.
constexpr double kSettlingConstants = 12.0;
/// Tolerance for measurements that arrive a period early or late, and for an axis slightly above its largest velocity.
constexpr double kVelocityMargin = 1.25;
/// Fraction of the noise: when both filters are this close to standstill, they are set exactly to it.
constexpr double kAtRest = 1e-6;
/// Lower bound of that distance for an object without noise, rad or m.
constexpr double kLeastRest = 1e-12;

std::uint32_t steps_of(double time_s, double period_s) noexcept {
  constexpr double kMaxCycles = 1e9;
  return static_cast<std::uint32_t>(std::clamp(std::ceil(time_s / period_s), 1.0, kMaxCycles));
}

}  // namespace

void PositionTracker::Motion::advance(double time_s, double jerk) noexcept {
  position += time_s * (velocity + time_s * (acceleration / 2.0 + time_s * jerk / 6.0));
  velocity += time_s * (acceleration + time_s * jerk / 2.0);
  acceleration += time_s * jerk;
}

PositionTracker::PositionTracker(const TrackerSettings& settings) noexcept : settings_(settings) {
  const double rate = 2.0 * std::numbers::pi * settings.cutoff_hz;
  const double period = settings.period_s;
  const double pole = std::exp(-rate * period);
  const double away = 1.0 - pole;
  g_ = 1.0 - pole * pole * pole;
  h_ = 1.5 * away * away * (1.0 + pole) / period;
  k_ = away * away * away / (period * period);
  // Poles of a triple integrator that is driven by its jerk, held for a period, with z - 1 = w:
  // w^3 + c w^2 + b w (w + 2) / 2 + a (w^2 + 6 w + 6) / 6 = (w + away)^3.
  const double a = away * away * away;
  const double b = 3.0 * away * away - a;
  const double c = 3.0 * away - b / 2.0 - a / 6.0;
  to_position_ = a / (period * period * period);
  to_velocity_ = b / (period * period);
  to_acceleration_ = c / period;
  settling_steps_ = steps_of(kSettlingConstants / rate, period);
  standing_steps_ = steps_of(kStandingS, period);
}

void PositionTracker::begin(double measured) noexcept {
  state_ = State::kSettling;
  settling_ = settling_steps_;
  missing_ = 0;
  standing_ = false;
  still_ = 0;
  last_ = lowest_ = highest_ = measured;
  estimate_ = smooth_ = {measured, 0.0, 0.0};
}

void PositionTracker::step(double measured) noexcept {
  if (!std::isfinite(measured)) return step();
  if (state_ == State::kLost) return begin(measured);
  const double possible = kVelocityMargin * settings_.max_velocity * settings_.period_s * (missing_ + 2.0);
  if (std::abs(measured - last_) > possible + 2.0 * settings_.noise) {
    ++leaps_;
    return step();
  }
  missing_ = 0;
  last_ = measured;
  follow();
  estimate_.advance(settings_.period_s, 0.0);
  correct(stood(measured));
  if (state_ == State::kSettling && --settling_ == 0) state_ = State::kTracking;
}

void PositionTracker::step() noexcept {
  if (state_ == State::kLost) return;
  if (++missing_ > settings_.most_missing) {
    state_ = State::kLost;
    standing_ = false;
    return;
  }
  follow();
  estimate_.advance(settings_.period_s, 0.0);
}

void PositionTracker::correct(double measured) noexcept {
  const double beside = measured - estimate_.position;
  estimate_.position += g_ * beside;
  estimate_.velocity += h_ * beside;
  estimate_.acceleration += k_ * beside;
}

/// Moves the output of the second filter towards the estimate, from the last step to this one.
void PositionTracker::follow() noexcept {
  const double jerk = to_position_ * (estimate_.position - smooth_.position) +
                      to_velocity_ * (estimate_.velocity - smooth_.velocity) +
                      to_acceleration_ * (estimate_.acceleration - smooth_.acceleration);
  smooth_.advance(settings_.period_s, jerk);
  if (!standing_) return;
  const double rest = std::max(kAtRest * settings_.noise, kLeastRest);
  const bool there = std::abs(smooth_.position - place_) < rest && std::abs(estimate_.position - place_) < rest &&
                     std::abs(smooth_.velocity) * settings_.period_s < rest &&
                     std::abs(estimate_.velocity) * settings_.period_s < rest;
  if (there) estimate_ = smooth_ = {place_, 0.0, 0.0};
}

/// Returns the measurement, or the position of the standstill.
double PositionTracker::stood(double measured) noexcept {
  const double band = 2.0 * settings_.noise;
  if (standing_) {
    if (std::abs(measured - place_) <= band) return place_;
    standing_ = false;
    still_ = 0;
    lowest_ = highest_ = measured;
    return measured;
  }
  lowest_ = std::min(lowest_, measured);
  highest_ = std::max(highest_, measured);
  if (highest_ - lowest_ > band) {
    still_ = 0;
    lowest_ = highest_ = measured;
  } else if (++still_ >= standing_steps_) {
    standing_ = true;
    place_ = std::midpoint(lowest_, highest_);
    return place_;
  }
  return measured;
}

AxisSetpoint PositionTracker::at(double later_s) const noexcept {
  Motion later = smooth_;
  later.advance(later_s, 0.0);
  return {later.position, later.velocity, later.acceleration};
}

}  // namespace driveline::trajectory
