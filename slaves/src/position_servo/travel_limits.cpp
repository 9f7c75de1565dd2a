#include "driveline/slaves/position_servo/travel_limits.hpp"

namespace driveline::slaves::position_servo {
namespace {

/// A drive that is disabled needs no other reaction.
LimitMode stronger(LimitMode a, LimitMode b) noexcept {
  if (a == LimitMode::kDisable || b == LimitMode::kDisable) return LimitMode::kDisable;
  return a == LimitMode::kOff ? b : a;
}

}  // namespace

LimitMode TravelLimits::hit(const LimitInputs& inputs) const noexcept {
  if (inputs.direction == 0) return LimitMode::kOff;
  const bool forward = inputs.direction > 0;
  const bool on_switch = forward ? inputs.positive_switch : inputs.negative_switch;
  const bool beyond = settings_.negative != settings_.positive &&
                      (forward ? inputs.position >= settings_.positive : inputs.position <= settings_.negative);
  return stronger(on_switch ? settings_.switches : LimitMode::kOff, beyond ? settings_.software : LimitMode::kOff);
}

TravelLimits::Reaction TravelLimits::step(const LimitInputs& inputs) noexcept {
  negative_switch_ = inputs.negative_switch;
  positive_switch_ = inputs.positive_switch;
  const LimitMode before = active_;
  active_ = hit(inputs);
  if (active_ == LimitMode::kOff || active_ == before || before == LimitMode::kDisable) return Reaction::kNone;
  return active_ == LimitMode::kDisable ? Reaction::kDisable : Reaction::kStop;
}

}  // namespace driveline::slaves::position_servo
