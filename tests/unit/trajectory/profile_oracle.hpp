#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "support.hpp"
#include "support/campaign.hpp"

// Judges profiles by their setpoints alone, without knowledge of how profiles are computed.
namespace driveline::trajectory::test {

/// The required motion of a profile.
struct Motion {
  AxisSetpoint from;
  AxisSetpoint to;
  ProfileLimits limits;

  /// The motion in the notation of test sources.
  [[nodiscard]] std::string text() const {
    std::ostringstream out;
    out.precision(17);
    out << "Motion{{" << from.position << ", " << from.velocity << ", " << from.acceleration << "}, {" << to.position
        << ", " << to.velocity << ", " << to.acceleration << "}, {" << limits.max_velocity << ", "
        << limits.min_velocity << ", " << limits.max_acceleration << ", " << limits.min_acceleration << ", "
        << limits.max_jerk << "}}";
    return out.str();
  }
};

/// Number of rounds of a random campaign: this build's share of `usual`, or what the environment variable
/// DRIVELINE_PROFILE_ROUNDS says.
inline int profile_rounds(int usual) {
  const char* text = std::getenv("DRIVELINE_PROFILE_ROUNDS");
  return text == nullptr ? driveline::test::share_of(usual) : std::atoi(text);
}

/// The velocity that remains when the acceleration is reduced to zero as fast as possible.
inline double velocity_at_rest(double velocity, double acceleration, double jerk) {
  return velocity + acceleration * std::abs(acceleration) / (2.0 * jerk);
}

/// Whether a state is inside the limits and need not leave them.
inline bool is_inside(const AxisSetpoint& state, const ProfileLimits& limits) {
  const double rest = velocity_at_rest(state.velocity, state.acceleration, limits.max_jerk);
  return state.velocity <= limits.max_velocity && state.velocity >= limits.min_velocity &&
         (!std::isfinite(limits.max_jerk) ||
          (state.acceleration <= limits.max_acceleration && state.acceleration >= limits.min_acceleration)) &&
         rest <= limits.max_velocity && rest >= limits.min_velocity;
}

/// Whether a motion from inside the limits can end in this state.
inline bool is_reachable(const AxisSetpoint& state, const ProfileLimits& limits) {
  return is_inside(
      {state.position, state.velocity, -state.acceleration},
      {limits.max_velocity, limits.min_velocity, -limits.min_acceleration, -limits.max_acceleration, limits.max_jerk});
}

/// Checks a profile from outside: samples it, differentiates the samples, and compares them with limits and end states.
class ProfileOracle {
 public:
  explicit ProfileOracle(const Motion& motion, int samples = 200) : motion_(motion), samples_(samples) {}

  /// Why the profile is wrong; empty: it is right. `kept_from_s`: time from which on the limits must be kept.
  [[nodiscard]] std::string complaint(const Profile& profile, double kept_from_s = 0.0) {
    profile_ = &profile;
    set_scales();
    std::string text = ends();
    const double duration_s = profile.duration_s();
    for (int i = 0; text.empty() && i < samples_ && duration_s > 0.0; ++i) {
      text = step(duration_s * i / samples_, std::min(duration_s, duration_s * (i + 1) / samples_), kept_from_s);
    }
    return text.empty() ? text : text + "\n" + motion_.text();
  }

 private:
  // Rounding grows with the magnitudes during the motion, so tolerances are relative to these.
  void set_scales() {
    const double duration_s = profile_->duration_s();
    position_ = std::max({std::abs(motion_.from.position), std::abs(motion_.to.position)});
    velocity_ = std::max(std::abs(motion_.from.velocity), std::abs(motion_.to.velocity));
    acceleration_ = std::max(std::abs(motion_.from.acceleration), std::abs(motion_.to.acceleration));
    for (int i = 0; i <= samples_; ++i) {
      const AxisSetpoint at = profile_->evaluate(std::min(duration_s, duration_s * i / samples_));
      position_ = std::max(position_, std::abs(at.position));
      velocity_ = std::max(velocity_, std::abs(at.velocity));
      acceleration_ = std::max(acceleration_, std::abs(at.acceleration));
    }
    position_ += velocity_ * duration_s;
    velocity_ += acceleration_ * duration_s;
  }

  [[nodiscard]] std::string ends() const {
    const double duration_s = profile_->duration_s();
    const AxisSetpoint first = profile_->evaluate(0.0);
    const AxisSetpoint last = profile_->evaluate(duration_s);
    if (duration_s > 0.0 && (first.position != motion_.from.position || first.velocity != motion_.from.velocity)) {
      return "does not begin where it shall";
    }
    if (last.position != motion_.to.position || last.velocity != motion_.to.velocity ||
        (std::isfinite(motion_.limits.max_jerk) && last.acceleration != motion_.to.acceleration)) {
      return "does not end where it shall";
    }
    if (!(duration_s >= 0.0) || !std::isfinite(duration_s)) {
      return "has no duration";
    }
    return {};
  }

  [[nodiscard]] static std::string too_much(const char* what, double t, double value, double limit) {
    std::ostringstream out;
    out.precision(17);
    out << what << " is " << value << ", limit " << limit << ", at " << t << " s";
    return out.str();
  }

  /// Checks the change between two samples: it is within the limits for this time, and the changes of position and
  /// velocity match velocity and acceleration.
  [[nodiscard]] std::string step(double begin_s, double end_s, double kept_from_s) const {
    const ProfileLimits& limits = motion_.limits;
    const double h = end_s - begin_s;
    const AxisSetpoint a = profile_->evaluate(begin_s);
    const AxisSetpoint m = profile_->evaluate(begin_s + h / 2.0);
    const AxisSetpoint b = profile_->evaluate(end_s);
    const bool has_jerk_limit = std::isfinite(limits.max_jerk);
    // Simpson's rule is exact within a phase, but not where the jerk or the acceleration jumps.
    const double jump = has_jerk_limit ? limits.max_jerk * h : limits.max_acceleration - limits.min_acceleration;
    const double way_error = b.position - a.position - h / 6.0 * (a.velocity + 4.0 * m.velocity + b.velocity);
    if (std::abs(way_error) > jump * h * h + kRounding * position_) {
      return too_much("position less the sum of velocity", begin_s, way_error, jump * h * h);
    }
    const double gain_error =
        b.velocity - a.velocity - h / 6.0 * (a.acceleration + 4.0 * m.acceleration + b.acceleration);
    if (std::abs(gain_error) > jump * h + kRounding * velocity_) {
      return too_much("velocity less the sum of acceleration", begin_s, gain_error, jump * h);
    }
    const double jerk = (b.acceleration - a.acceleration) / h;
    const double duration_s = profile_->duration_s();
    const double swing = has_jerk_limit ? limits.max_jerk * duration_s : 0.0;
    const double noise = kRounding * (acceleration_ + velocity_ / duration_s + swing) / h;
    if (has_jerk_limit && std::abs(jerk) > limits.max_jerk * (1.0 + kKept) + noise) {
      return too_much("jerk", begin_s, jerk, limits.max_jerk);
    }
    return begin_s < kept_from_s ? std::string() : inside(begin_s, a, (b.velocity - a.velocity) / h, h);
  }

  [[nodiscard]] std::string inside(double t, const AxisSetpoint& at, double change, double h) const {
    const ProfileLimits& limits = motion_.limits;
    const double noise = kRounding * velocity_ / h;
    if (change > limits.max_acceleration * (1.0 + kKept) + noise ||
        change < limits.min_acceleration * (1.0 + kKept) - noise) {
      return too_much("change of velocity", t, change,
                      change > 0.0 ? limits.max_acceleration : limits.min_acceleration);
    }
    if (at.acceleration > limits.max_acceleration * (1.0 + kKept) ||
        at.acceleration < limits.min_acceleration * (1.0 + kKept)) {
      return too_much("acceleration", t, at.acceleration, limits.max_acceleration);
    }
    const double speed_noise = 1e-14 * velocity_;
    if (at.velocity > limits.max_velocity * (1.0 + kKept) + speed_noise ||
        at.velocity < limits.min_velocity * (1.0 + kKept) - speed_noise) {
      return too_much("velocity", t, at.velocity, at.velocity > 0.0 ? limits.max_velocity : limits.min_velocity);
    }
    return {};
  }

  static constexpr double kKept = 1e-12;      // tolerance of the limits
  static constexpr double kRounding = 1e-12;  // rounding of sums, relative to the largest term

  Motion motion_;
  int samples_;
  const Profile* profile_ = nullptr;
  double position_ = 0.0;
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
};

/// The fastest of very many motions that obey the limits, as a bound for the duration of a planned motion: two changes
/// of velocity, each as fast as possible, that meet in one of a grid of states, with a stretch of constant velocity if
/// they meet without acceleration. The start must be inside the limits.
class ProfileSearch {
 public:
  explicit ProfileSearch(const Motion& motion) : m_(motion) {}

  [[nodiscard]] double shortest_s(int velocities, int accelerations) {
    best_s_ = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 2 * accelerations; ++k) {
      const double share = std::abs(k - accelerations) / static_cast<double>(accelerations);
      const double a = share * (k < accelerations ? m_.limits.min_acceleration : m_.limits.max_acceleration);
      search_line(a, velocities);
    }
    return best_s_;
  }

 private:
  struct Result {
    double way = 0.0;
    double duration_s = 0.0;
    bool is_inside = true;
  };

  void search_line(double a, int velocities) {
    const double low = m_.limits.min_velocity;
    const double high = m_.limits.max_velocity;
    const double wanted = m_.to.position - m_.from.position;
    Result before;
    double at_before = low;
    for (int i = 0; i <= velocities; ++i) {
      const double v = low + (high - low) * i / velocities;
      const Result here = through(v, a);
      if (a == 0.0 && here.is_inside && (wanted - here.way) * v > 0.0) {
        best_s_ = std::min(best_s_, here.duration_s + (wanted - here.way) / v);
      }
      if (i > 0 && here.is_inside && before.is_inside && (before.way - wanted) * (here.way - wanted) <= 0.0) {
        bisect(at_before, v, a, wanted);
      }
      before = here;
      at_before = v;
    }
  }

  void bisect(double low, double high, double a, double wanted) {
    const bool rises = through(high, a).way > through(low, a).way;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2.0;
      (through(middle, a).way < wanted) == rises ? low = middle : high = middle;
    }
    // Where the distance jumps there is no motion in between.
    const Result one = through(low, a);
    const Result other = through(high, a);
    if (one.is_inside && other.is_inside && std::abs(one.way - other.way) < 1e-9 * (1.0 + std::abs(wanted))) {
      best_s_ = std::min(best_s_, std::max(one.duration_s, other.duration_s));
    }
  }

  [[nodiscard]] Result through(double v, double a) const {
    Result result;
    change(result, m_.from.velocity, m_.from.acceleration, v, a);
    change(result, v, a, m_.to.velocity, m_.to.acceleration);
    return result;
  }

  /// The fastest change of velocity: to an extreme acceleration, held if it is a limit, then to the final acceleration.
  void change(Result& result, double v0, double a0, double v1, double a1) const {
    const double j = m_.limits.max_jerk;
    const double straight = (a1 - a0) * (a1 + a0) / (2.0 * (a1 < a0 ? -j : j));
    const double sign = v1 - v0 >= straight ? 1.0 : -1.0;
    const double limit = sign > 0.0 ? m_.limits.max_acceleration : -m_.limits.min_acceleration;
    const double squared = sign * j * (v1 - v0) + (a0 * a0 + a1 * a1) / 2.0;
    double extreme = std::max({std::sqrt(std::max(0.0, squared)), sign * a0, sign * a1});
    double hold_s = 0.0;
    if (extreme > limit) {
      hold_s = (extreme * extreme - limit * limit) / (j * limit);
      extreme = limit;
    }
    double v = v0;
    phase(result, v, a0, sign * j, (extreme - sign * a0) / j);
    phase(result, v, sign * extreme, 0.0, hold_s);
    phase(result, v, sign * extreme, -sign * j, (extreme - sign * a1) / j);
  }

  void phase(Result& result, double& v, double a, double j, double t) const {
    const double turn_s = j != 0.0 ? -a / j : -1.0;
    for (const double at : {turn_s, t}) {
      const double there = v + at * (a + at * j / 2.0);
      if (at >= 0.0 && at <= t && (there > m_.limits.max_velocity + 1e-9 || there < m_.limits.min_velocity - 1e-9)) {
        result.is_inside = false;
      }
    }
    result.way += t * (v + t * (a / 2.0 + t * j / 6.0));
    result.duration_s += t;
    v += t * (a + t * j / 2.0);
  }

  Motion m_;
  double best_s_ = 0.0;
};

}  // namespace driveline::trajectory::test
