#include "driveline/trajectory/coupling.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/velocity_profile.hpp"

namespace driveline::trajectory {
namespace {

/// Relative excess over a limit that counts as rounding.
constexpr double kLimitRounding = 1e-9;
/// Relative rounding error of a position.
constexpr double kPlaceRounding = 1e-15;
/// Share of the slave's present reserve that a deviation may use if the master may demand all of it later.
constexpr double kShareOfRoom = 0.8;
/// Minimum share of each limit for a deviation.
constexpr double kLeastVelocity = 0.02;
constexpr double kLeastShare = 0.25;
/// Share of the jerk limit for a deviation if the jerk of the master is unknown.
constexpr double kUnknownJerk = 0.5;
/// A deviation is planned again when its limits have grown by this factor.
constexpr double kWorthwhile = 1.5;
/// Largest accepted excess of the velocity between two steps, relative to the limit; never more than the jerk causes
/// within a step.
constexpr double kBetweenSteps = 1e-6;

bool is_finite_state(const AxisSetpoint& state) noexcept {
  return std::isfinite(state.position) && std::isfinite(state.velocity) && std::isfinite(state.acceleration);
}

AxisSetpoint difference(const AxisSetpoint& one, const AxisSetpoint& other) noexcept {
  return {one.position - other.position, one.velocity - other.velocity, one.acceleration - other.acceleration};
}

AxisSetpoint sum(const AxisSetpoint& one, const AxisSetpoint& other) noexcept {
  return {one.position + other.position, one.velocity + other.velocity, one.acceleration + other.acceleration};
}

/// The highest acceleration at the end of a step of constant jerk after which a velocity limit can still be kept.
double highest_acceleration(double velocity, double acceleration, double limit, double jerk, double period_s) noexcept {
  const double room = limit - velocity - 0.5 * acceleration * period_s;
  if (room < 0.0) return 2.0 * room / period_s;
  const double half = 0.5 * jerk * period_s;
  return std::sqrt(half * half + 2.0 * jerk * room) - half;
}

}  // namespace

Coupling::Coupling(const FollowLimits& limits, double period_s) noexcept
    : max_velocity_(limits.motion.max_velocity),
      max_acceleration_(limits.motion.max_acceleration),
      // Without a jerk limit: from one end of the acceleration range to the other in one step.
      max_jerk_(std::min(limits.max_jerk, 2.0 * limits.motion.max_acceleration / period_s)),
      period_s_(period_s) {}

void Coupling::begin(const CouplingLaw& law, CatchUp catch_up, const AxisSetpoint& slave) noexcept {
  law_ = law;
  catch_up_ = catch_up;
  run_in_.reset();
  deviation_.reset();
  phase_ = {};
  phase_profile_.reset();
  last_ = {slave.position, slave.velocity, slave.acceleration};
  step_velocity_.reset();
  losses_ = 0;
}

CouplingRefusal Coupling::engage(const CouplingLaw& law, CatchUp catch_up, const AxisSetpoint& slave,
                                 const AxisSetpoint& master) noexcept {
  const auto value = law.at(master.position);
  const auto wanted = along(value, master);
  if (!is_finite_state(slave) || !is_finite_state(master) || !is_finite_state(wanted))
    return CouplingRefusal::kNotFinite;
  begin(law, catch_up, slave);
  state_ = CouplingState::kCatchingUp;
  if (!plan_deviation(wanted, value.slope)) release(Release::kStop);
  return CouplingRefusal::kNone;
}

CouplingRefusal Coupling::engage_at(const CouplingLaw& law, const SyncPlace& place, const AxisSetpoint& slave,
                                    const AxisSetpoint& master) noexcept {
  const auto end = law.at(place.master);
  const bool finite = is_finite_state(slave) && is_finite_state(master) && std::isfinite(place.master) &&
                      std::isfinite(place.distance) && place.distance >= 0.0;
  if (!finite || !is_finite_state(along(end, master))) return CouplingRefusal::kNotFinite;
  const auto limits = ProfileLimits::symmetric(max_velocity_, max_acceleration_, jerk_from(slave));
  const auto halt = plan_to_standstill(slave, limits);
  if (!halt) return CouplingRefusal::kNotFinite;
  const double rest = halt->end().position;
  const double ahead = place.master - master.position;
  const double distance =
      place.distance > 0.0 ? std::copysign(place.distance, ahead) : 2.0 * (end.position - rest) / end.slope;
  if (!std::isfinite(distance) || !(std::abs(distance) > 0.0)) return CouplingRefusal::kNoWay;
  if (!(distance * ahead > 0.0)) return place.distance > 0.0 ? CouplingRefusal::kTooLate : CouplingRefusal::kNoWay;
  if (std::abs(distance) > std::abs(ahead)) return CouplingRefusal::kTooLate;
  const RunIn run_in(rest, place.master, distance, end);
  const auto needed = run_in.demand(master.velocity);
  constexpr double kWithin = 1.0 + kLimitRounding;
  if (needed.velocity > max_velocity_ * kWithin || needed.acceleration > max_acceleration_ * kWithin ||
      needed.jerk > max_jerk_ * kWithin)
    return CouplingRefusal::kTooSteep;
  begin(law, CatchUp::kPosition, slave);
  run_in_ = run_in;
  state_ = CouplingState::kWaiting;
  if (!plan_deviation({rest, 0.0, 0.0}, 0.0)) release(Release::kStop);
  return CouplingRefusal::kNone;
}

void Coupling::moved_to(const AxisSetpoint& slave) noexcept {
  if (state_ == CouplingState::kIdle || state_ == CouplingState::kReleased) return;
  last_ = {slave.position, slave.velocity, slave.acceleration};
  step_velocity_ = slave.velocity;
  // A single step cannot reach the next demand, so a new deviation will be planned.
  deviation_.reset();
  if (state_ == CouplingState::kInSync) state_ = CouplingState::kCatchingUp;
}

void Coupling::release(Release how) noexcept {
  if (state_ == CouplingState::kIdle) return;
  const auto limits = ProfileLimits::symmetric(max_velocity_, max_acceleration_, jerk_from(last_));
  const double velocity = how == Release::kStop ? 0.0 : std::clamp(last_.velocity, -max_velocity_, max_velocity_);
  const auto planned = plan_to_velocity(last_, velocity, 0.0, limits);
  // A plan fails only for values that are not finite; the axis then keeps its velocity.
  exit_ = planned ? *planned : Profile(last_);
  elapsed_s_ = 0.0;
  run_in_.reset();
  deviation_.reset();
  phase_profile_.reset();
  state_ = CouplingState::kReleased;
}

bool Coupling::shift_phase_to(double offset, const ProfileLimits& limits) noexcept {
  const auto planned = plan_to_position(phase_, {offset, 0.0, 0.0}, limits);
  if (!planned) return false;
  phase_profile_ = *planned;
  phase_s_ = 0.0;
  return true;
}

void Coupling::advance_phase() noexcept {
  if (!phase_profile_) return;
  phase_s_ += period_s_;
  phase_ = phase_profile_->evaluate(phase_s_);
  if (!phase_profile_->finished(phase_s_)) return;
  phase_ = {phase_profile_->end().position, 0.0, 0.0};
  phase_profile_.reset();
}

/// The master as the law sees it, offset included.
AxisSetpoint Coupling::leading(const AxisSetpoint& master) const noexcept {
  return sum(master, phase_);
}

/// Value of the run-in until it is over, then of the law.
Cam::Value Coupling::value_at(double master) noexcept {
  if (run_in_) {
    const double part = run_in_->part(master);
    if (part < 1.0) {
      state_ = part > 0.0 ? CouplingState::kRunningIn : CouplingState::kWaiting;
      return run_in_->at(master);
    }
    run_in_.reset();
    state_ = deviation_ ? CouplingState::kCatchingUp : CouplingState::kInSync;
  }
  return law_.at(master);
}

/// The law plus the remaining deviation.
AxisSetpoint Coupling::deviated(const AxisSetpoint& wanted) noexcept {
  if (!deviation_) return wanted;
  elapsed_s_ += period_s_;
  if (!deviation_->finished(elapsed_s_)) return sum(wanted, deviation_->evaluate(elapsed_s_));
  const double left = deviation_->end().position;
  deviation_.reset();
  if (catch_up_ == CatchUp::kVelocity) law_.shift(left);
  catch_up_ = CatchUp::kPosition;
  if (!run_in_) state_ = CouplingState::kInSync;
  return {wanted.position + left, wanted.velocity, wanted.acceleration};
}

AxisSetpoint Coupling::step(const AxisSetpoint& master) noexcept {
  if (state_ == CouplingState::kIdle) return last_;
  if (state_ == CouplingState::kReleased) return free_step();
  advance_phase();
  const auto lead = leading(master);
  const auto value = value_at(lead.position);
  const auto wanted = along(value, lead);
  if (!is_finite_state(wanted)) {
    release(Release::kStop);
    return free_step();
  }
  const bool strict = state_ != CouplingState::kInSync;
  const auto next = deviated(wanted);
  if (!is_allowed(next) || (strict && !keeps_jerk(next))) return limited_step(next, wanted, value.slope);
  take(next);
  if (!deviation_ && state_ == CouplingState::kCatchingUp) state_ = CouplingState::kInSync;
  if (deviation_ && could_be_faster(wanted, value.slope) && !plan_deviation(wanted, value.slope))
    release(Release::kStop);
  return last_;
}

/// Whether the deviation was planned when the slave had considerably less reserve.
bool Coupling::could_be_faster(const AxisSetpoint& wanted, double slope) const noexcept {
  const auto limits = deviation_limits(wanted, slope);
  return limits.max_velocity > kWorthwhile * deviation_limits_.max_velocity ||
         limits.min_velocity < kWorthwhile * deviation_limits_.min_velocity ||
         limits.max_acceleration > kWorthwhile * deviation_limits_.max_acceleration;
}

AxisSetpoint Coupling::free_step() noexcept {
  elapsed_s_ += period_s_;
  return take(exit_.evaluate(elapsed_s_));
}

/// The demand is not possible: take the nearest possible step, and plan a new deviation from there.
AxisSetpoint Coupling::limited_step(const AxisSetpoint& next, const AxisSetpoint& wanted, double slope) noexcept {
  const bool lost = state_ == CouplingState::kInSync;
  if (lost) ++losses_;
  if (lost && on_loss_ == OnLoss::kStop) {
    release(Release::kStop);
    return free_step();
  }
  const auto taken = take(nearest(next.acceleration));
  if (lost) state_ = CouplingState::kCatchingUp;
  if (!plan_deviation(wanted, slope)) release(Release::kStop);
  return taken;
}

AxisSetpoint Coupling::take(const AxisSetpoint& next) noexcept {
  step_velocity_ = (next.position - last_.position) / period_s_;
  last_ = next;
  return next;
}

bool Coupling::plan_deviation(const AxisSetpoint& wanted, double slope) noexcept {
  const auto from = difference(last_, wanted);
  const auto limits = deviation_limits(wanted, slope);
  const auto planned =
      catch_up_ == CatchUp::kVelocity ? plan_to_velocity(from, 0.0, 0.0, limits) : plan_to_position(from, {}, limits);
  if (!planned) return false;
  deviation_ = *planned;
  deviation_limits_ = limits;
  elapsed_s_ = 0.0;
  return true;
}

/// Limits that remain for a deviation from the law if the master uses its own limits.
ProfileLimits Coupling::deviation_limits(const AxisSetpoint& wanted, double slope) const noexcept {
  const double gain = std::abs(slope);
  const auto times = [gain](double bound) { return gain > 0.0 ? gain * bound : 0.0; };
  const double always = max_velocity_ - times(bounds_.motion.max_velocity);
  const double least = kLeastVelocity * max_velocity_;
  const double accelerating = times(bounds_.motion.max_acceleration);
  const double most_kept = (1.0 - kLeastShare) * max_acceleration_;
  const double kept = accelerating <= most_kept
                          ? accelerating
                          : std::clamp(1.5 * std::abs(wanted.acceleration), kLeastShare * max_acceleration_, most_kept);
  const double jerk = times(bounds_.max_jerk);
  ProfileLimits limits;
  limits.max_velocity = std::max({always, kShareOfRoom * (max_velocity_ - wanted.velocity), least});
  limits.min_velocity = -std::max({always, kShareOfRoom * (max_velocity_ + wanted.velocity), least});
  limits.max_acceleration = max_acceleration_ - kept;
  limits.min_acceleration = -limits.max_acceleration;
  limits.max_jerk = jerk <= (1.0 - kLeastShare) * max_jerk_ ? max_jerk_ - jerk : kUnknownJerk * max_jerk_;
  return limits;
}

/// Whether the limits of velocity and acceleration are kept, by the given values and by the change of the positions.
bool Coupling::is_allowed(const AxisSetpoint& next) const noexcept {
  constexpr double kWithin = 1.0 + kLimitRounding;
  if (!(std::abs(next.velocity) <= max_velocity_ * kWithin)) return false;
  if (!(std::abs(next.acceleration) <= max_acceleration_ * kWithin)) return false;
  // Excess of the velocity if the acceleration ends within the next step.
  const double between = std::min(max_jerk_ * period_s_ * period_s_ / 8.0, kBetweenSteps * max_velocity_);
  if (std::abs(next.velocity + 0.5 * next.acceleration * period_s_) > max_velocity_ * kWithin + between) return false;
  const double rounding = kPlaceRounding * std::abs(next.position) / period_s_;
  const double velocity = (next.position - last_.position) / period_s_;
  if (std::abs(velocity) > max_velocity_ * kWithin + rounding) return false;
  if (!step_velocity_) return true;
  return std::abs(velocity - *step_velocity_) <= max_acceleration_ * period_s_ * kWithin + 2.0 * rounding;
}

/// Whether the jerk limit is kept, and the velocity limit can still be kept with it.
bool Coupling::keeps_jerk(const AxisSetpoint& next) const noexcept {
  constexpr double kWithin = 1.0 + kLimitRounding;
  const double change = std::abs(next.acceleration - last_.acceleration);
  if (change > max_jerk_ * period_s_ * kWithin + kLimitRounding * max_acceleration_) return false;
  const double rest = next.velocity + 0.5 * next.acceleration * std::abs(next.acceleration) / max_jerk_;
  return std::abs(rest) <= max_velocity_ * kWithin;
}

/// Returns the jerk limit, raised if the axis already accelerates so hard that it cannot keep the velocity limit
/// otherwise: the velocity has precedence.
double Coupling::jerk_from(const AxisSetpoint& state) const noexcept {
  const double room = state.acceleration > 0.0 ? max_velocity_ - state.velocity : max_velocity_ + state.velocity;
  const double needed = 0.5 * state.acceleration * state.acceleration * (1.0 + kLimitRounding);
  return max_jerk_ * room >= needed || !(room > 0.0) ? max_jerk_ : needed / room;
}

/// The step of constant jerk whose acceleration ends nearest to the requested one.
AxisSetpoint Coupling::nearest(double acceleration) const noexcept {
  const double jerk = jerk_from(last_);
  const double change = jerk * period_s_;
  const double least = last_.acceleration - change;
  const double most = last_.acceleration + change;
  const double highest = highest_acceleration(last_.velocity, last_.acceleration, max_velocity_, jerk, period_s_);
  const double lowest = -highest_acceleration(-last_.velocity, -last_.acceleration, max_velocity_, jerk, period_s_);
  double to = std::clamp(acceleration, least, most);
  to = std::max(std::min(to, highest), lowest);
  // An axis that started above its velocity limit is braked within its jerk limit.
  if (std::abs(last_.velocity) > max_velocity_ * (1.0 + kLimitRounding)) to = std::clamp(to, least, most);
  to = std::clamp(to, std::min(-max_acceleration_, most), std::max(max_acceleration_, least));
  return {last_.position + (last_.velocity + (2.0 * last_.acceleration + to) * period_s_ / 6.0) * period_s_,
          last_.velocity + 0.5 * (last_.acceleration + to) * period_s_, to};
}

std::string_view to_text(CouplingRefusal refusal) noexcept {
  switch (refusal) {
    case CouplingRefusal::kNone:
      return "nothing is wrong";
    case CouplingRefusal::kNotFinite:
      return "a state or a position is not a finite number";
    case CouplingRefusal::kTooLate:
      return "the master has already passed the position where the slave must start";
    case CouplingRefusal::kNoWay:
      return "the slave cannot reach the position without reversing: give the master distance over which it starts";
    case CouplingRefusal::kTooSteep:
      return "the slave would exceed its limits at the velocity of the master: the distance is too short";
  }
  return "?";
}

}  // namespace driveline::trajectory
