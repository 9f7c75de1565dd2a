#include "driveline/slaves/cia402/profile_generator.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::slaves {
namespace {

constexpr double kSmallest = 1e-12;  ///< minimum of the limits: keeps the arithmetic finite for all inputs
constexpr int kBisections = 60;      ///< bisections of the peak speed: to the resolution of a double

double positive(double value) noexcept {
  return std::isfinite(value) ? std::max(value, kSmallest) : kSmallest;
}
double finite(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

}  // namespace

/// Planned phases, with the state at their end.
struct ProfileGenerator::Plan {
  std::array<Phase, kMaxPhases> phases{};
  std::size_t count = 0;
  ProfileState end;

  void add(double duration_s, double jerk) noexcept { add(duration_s, end.acceleration, jerk); }
  void add(double duration_s, double acceleration, double jerk) noexcept {
    if (!(duration_s > 0.0) || count == kMaxPhases) return;
    phases[count++] = {duration_s, acceleration, jerk};
    const double t = duration_s;
    end.position += t * (end.velocity + t * (0.5 * acceleration + t * jerk / 6.0));
    end.velocity += t * (acceleration + t * 0.5 * jerk);
    end.acceleration = acceleration + t * jerk;
  }
  void cruise(double duration_s) noexcept { add(duration_s, 0.0, 0.0); }

  /// Changes the speed to `v` with zero final acceleration. Passes standstill only if the initial acceleration forces
  /// it.
  void change_speed(double v, double limit, double jerk_time_s) noexcept {
    if (!(jerk_time_s > 0.0)) {
      const double change = v - end.velocity;
      add(std::abs(change) / limit, std::copysign(limit, change), 0.0);
      end.velocity = v;
      end.acceleration = 0.0;
      return;
    }
    const double jerk = limit / jerk_time_s;
    const double excess = std::abs(end.acceleration) - limit;
    if (excess > 0.0) {
      const double sign = std::copysign(1.0, end.acceleration);
      add(excess / jerk, -sign * jerk);
      end.acceleration = sign * limit;
    }
    const double without_more = end.velocity + end.acceleration * std::abs(end.acceleration) / (2.0 * jerk);
    const double sign = v >= without_more ? 1.0 : -1.0;
    const double start = sign * end.acceleration;
    const double change = sign * (v - end.velocity);
    double peak = std::sqrt(std::max(jerk * change + 0.5 * start * start, 0.0));
    double hold_s = 0.0;
    if (peak > limit) {
      hold_s = (change - (limit * limit - 0.5 * start * start) / jerk) / limit;
      peak = limit;
    }
    peak = std::max(peak, start);
    add((peak - start) / jerk, sign * jerk);
    add(hold_s, sign * peak, 0.0);
    add(peak / jerk, sign * peak, -sign * jerk);
    end.velocity = v;
    end.acceleration = 0.0;
  }

  void accelerate(double v, const GeneratorLimits& limits) noexcept {
    if (end.velocity * v < 0.0) change_speed(0.0, limits.deceleration, limits.jerk_time_s);
    const bool faster = std::abs(v) > std::abs(end.velocity);
    change_speed(v, faster ? limits.acceleration : limits.deceleration, limits.jerk_time_s);
  }

  /// Plans a movement from `start` to standstill via speed `peak`, which is held for `cruise_s`.
  static Plan over(const ProfileState& start, double peak, double cruise_s, const GeneratorLimits& limits) noexcept {
    Plan plan;
    plan.end = start;
    plan.accelerate(peak, limits);
    plan.cruise(cruise_s);
    plan.accelerate(0.0, limits);
    return plan;
  }
};

namespace {

GeneratorLimits sanitized(const GeneratorLimits& limits) noexcept {
  return {positive(limits.velocity), positive(limits.acceleration), positive(limits.deceleration),
          std::isfinite(limits.jerk_time_s) ? std::max(limits.jerk_time_s, 0.0) : 0.0};
}

}  // namespace

void ProfileGenerator::follow(const Plan& plan, const ProfileState& target, bool ends_at_position) noexcept {
  phases_ = plan.phases;
  count_ = plan.count;
  current_ = 0;
  elapsed_s_ = 0.0;
  base_ = state_;
  target_ = target;
  ends_at_position_ = ends_at_position;
  if (count_ == 0) arrive();
}

/// Ends a movement on its target state, without the rounding errors of its phases.
void ProfileGenerator::arrive() noexcept {
  base_.velocity = target_.velocity;
  base_.acceleration = 0.0;
  if (ends_at_position_) base_.position = target_.position;
  state_ = base_;
}

void ProfileGenerator::reset(const ProfileState& state) noexcept {
  state_ = {finite(state.position), finite(state.velocity), finite(state.acceleration)};
  Plan plan;
  follow(plan, {state_.position, state_.velocity, 0.0}, false);
  // For a movement that starts before the next step(); without one, step() sets it to 0.
  state_.acceleration = finite(state.acceleration);
}

/// The distance of a movement increases with its signed peak speed, so bisection finds the peak speed that just covers
/// the distance. A short cruise at that speed compensates the remaining rounding error.
void ProfileGenerator::move_to(double position, const GeneratorLimits& wanted) noexcept {
  const GeneratorLimits limits = sanitized(wanted);
  const double target = finite(position);
  const auto rest = [&](double peak) { return target - Plan::over(state_, peak, 0.0, limits).end.position; };
  double low = -limits.velocity;
  double high = limits.velocity;
  double peak = 0.0;
  if (rest(high) >= 0.0) {
    peak = high;
  } else if (rest(low) <= 0.0) {
    peak = low;
  } else {
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (low + high);
      (rest(middle) >= 0.0 ? low : high) = middle;
    }
    peak = low > 0.0 ? low : high < 0.0 ? high : 0.0;
  }
  const double cruise_s = peak > 0.0 || peak < 0.0 ? std::max(rest(peak) / peak, 0.0) : 0.0;
  follow(Plan::over(state_, peak, cruise_s, limits), {target, 0.0, 0.0}, true);
}

void ProfileGenerator::run_at(double velocity, const GeneratorLimits& wanted) noexcept {
  const GeneratorLimits limits = sanitized(wanted);
  Plan plan;
  plan.end = state_;
  plan.accelerate(finite(velocity), limits);
  follow(plan, {0.0, finite(velocity), 0.0}, false);
}

void ProfileGenerator::step(double step_s) noexcept {
  elapsed_s_ += step_s;
  const auto at = [this](const Phase& phase, double t) {
    return ProfileState{base_.position + t * (base_.velocity + t * (0.5 * phase.acceleration + t * phase.jerk / 6.0)),
                        base_.velocity + t * (phase.acceleration + t * 0.5 * phase.jerk),
                        phase.acceleration + t * phase.jerk};
  };
  while (current_ < count_ && elapsed_s_ >= phases_[current_].duration_s) {
    const Phase& phase = phases_[current_++];
    base_ = at(phase, phase.duration_s);
    elapsed_s_ -= phase.duration_s;
    if (current_ == count_) arrive();
  }
  if (current_ < count_) {
    state_ = at(phases_[current_], elapsed_s_);
  } else {
    state_ = {base_.position + elapsed_s_ * base_.velocity, base_.velocity, 0.0};
  }
}

}  // namespace driveline::slaves
