#include "support/profile_figures.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/synchronised_profiles.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using namespace driveline::trajectory;

constexpr std::size_t kFull = 10'000'000;
constexpr std::size_t kShort = 1'000'000;
constexpr std::size_t kQuick = 100'000;
constexpr std::size_t kProblemsAtATime =
    64;                               ///< problems that are also timed together, without reading the clock in between
constexpr std::size_t kSlowest = 16;  ///< slowest problems, planned again to distinguish them from disturbances
constexpr int kRepetitions = 101;
constexpr std::size_t kMaxAxes = 7;
constexpr double kKept = 1e-12;
constexpr double kMet = 1e-9;

/// SplitMix64: fast, and the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) noexcept : state_(seed) {}

  double real(double low, double high) noexcept {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return low + (high - low) * static_cast<double>(z >> 11U) * 0x1p-53;
  }
  bool one_in(double n) noexcept { return real(0.0, n) < 1.0; }

 private:
  std::uint64_t state_;
};

/// A motion between random states, one in ten from outside the limits; every second one ends at rest.
AxisMotion random_motion(Dice& dice) noexcept {
  AxisMotion motion;
  ProfileLimits& limits = motion.limits;
  limits = {dice.real(0.1, 12.0), -dice.real(0.1, 12.0), dice.real(0.1, 12.0), -dice.real(0.1, 12.0),
            dice.real(0.1, 12.0)};
  // For starts outside, the acceleration leads to velocities up to half as much outside the limits.
  const double reach = dice.one_in(10.0) ? 1.5 : 1.0;
  const double start = reach * dice.real(limits.min_velocity, limits.max_velocity);
  const double hardest = std::sqrt(2.0 * limits.max_jerk * (reach * limits.max_velocity - start));
  const double softest = -std::sqrt(2.0 * limits.max_jerk * (start - reach * limits.min_velocity));
  motion.from = {dice.real(-4.0, 4.0), start,
                 dice.real(std::max(softest, reach * limits.min_acceleration),
                           std::min(hardest, reach * limits.max_acceleration))};
  motion.to = {dice.real(-4.0, 4.0), 0.0, 0.0};
  if (!dice.one_in(2.0)) {
    const double velocity = 0.99 * dice.real(limits.min_velocity, limits.max_velocity);
    // Bounds of the final acceleration: it comes from, and leads to, velocities inside the limits.
    const double most = 0.99 * std::sqrt(2.0 * limits.max_jerk * (velocity - limits.min_velocity));
    const double least = -0.99 * std::sqrt(2.0 * limits.max_jerk * (limits.max_velocity - velocity));
    motion.to.velocity = velocity;
    motion.to.acceleration =
        dice.real(std::max(least, limits.min_acceleration), std::min(most, limits.max_acceleration));
  }
  return motion;
}

bool is_inside(const AxisMotion& motion) noexcept {
  const double rest = motion.from.velocity +
                      motion.from.acceleration * std::abs(motion.from.acceleration) / (2.0 * motion.limits.max_jerk);
  const auto within = [&](double velocity) {
    return velocity <= motion.limits.max_velocity && velocity >= motion.limits.min_velocity;
  };
  return within(motion.from.velocity) && within(rest) && motion.from.acceleration <= motion.limits.max_acceleration &&
         motion.from.acceleration >= motion.limits.min_acceleration;
}

/// Whether the phases lead from start to end within the limits, checked at their ends and where the acceleration
/// crosses zero between them.
bool is_right(const AxisMotion& motion, const Profile& profile) noexcept {
  const ProfileLimits& limits = motion.limits;
  const AxisSetpoint last = profile.evaluate(std::nextafter(profile.duration_s(), 0.0));
  const double duration_s = profile.duration_s();
  const double speed = std::max({std::abs(motion.from.velocity), limits.max_velocity, -limits.min_velocity});
  const double push = std::max({std::abs(motion.from.acceleration), limits.max_acceleration, -limits.min_acceleration});
  const double scale = 1.0 + duration_s * (speed + duration_s * std::min(push, limits.max_jerk * duration_s));
  if (!std::isfinite(duration_s) || !(std::abs(last.position - motion.to.position) <= kMet * scale) ||
      !(std::abs(last.velocity - motion.to.velocity) <= kMet * (1.0 + speed)) ||
      !(std::abs(last.acceleration - motion.to.acceleration) <= kMet * (1.0 + push))) {
    return duration_s == 0.0;
  }
  if (!is_inside(motion)) {
    return true;
  }
  const auto phases = profile.phases();
  const double noise = 1e-14 * (speed + push * duration_s);
  // Effect of the last digit of a time on the acceleration.
  const double swing = 4e-16 * duration_s * limits.max_jerk;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const Profile::Phase& phase = phases[i];
    const double length_s = (i + 1 < phases.size() ? phases[i + 1].begin_s : duration_s) - phase.begin_s;
    const double turn_s = phase.jerk != 0.0 ? std::clamp(-phase.acceleration / phase.jerk, 0.0, length_s) : 0.0;
    for (const double t : {0.0, turn_s, length_s}) {
      const double velocity = phase.velocity + t * (phase.acceleration + t * phase.jerk / 2.0);
      const double acceleration = phase.acceleration + t * phase.jerk;
      if (!(velocity <= limits.max_velocity * (1.0 + kKept) + noise) ||
          !(velocity >= limits.min_velocity * (1.0 + kKept) - noise) ||
          !(acceleration <= limits.max_acceleration * (1.0 + kKept) + swing) ||
          !(acceleration >= limits.min_acceleration * (1.0 + kKept) - swing)) {
        return false;
      }
    }
    if (std::abs(phase.jerk) > limits.max_jerk * (1.0 + kKept)) {
      return false;
    }
  }
  return true;
}

std::string text(const AxisMotion& motion) {
  return fmt::format("{{{{{}, {}, {}}}, {{{}, {}, {}}}, {{{}, {}, {}, {}, {}}}}}", motion.from.position,
                     motion.from.velocity, motion.from.acceleration, motion.to.position, motion.to.velocity,
                     motion.to.acceleration, motion.limits.max_velocity, motion.limits.min_velocity,
                     motion.limits.max_acceleration, motion.limits.min_acceleration, motion.limits.max_jerk);
}

/// Plans problems of a number of axes, which end together.
class Planning {
 public:
  explicit Planning(std::size_t axes) noexcept : axes_(axes) {}

  /// Times `count` problems, one by one and in batches.
  void measure(std::size_t count) {
    Dice dice(kMaxAxes * 1000 + axes_);
    each_ns_.reserve(count);
    std::vector<AxisMotion> batch(kProblemsAtATime * axes_);
    for (std::size_t done = 0; done < count; done += kProblemsAtATime) {
      std::generate(batch.begin(), batch.end(), [&] { return random_motion(dice); });
      measure_one_by_one(batch);
      const double begin = now_ns();
      for (std::size_t i = 0; i < kProblemsAtATime; ++i) {
        keep(plan(problem(batch, i)));
      }
      batch_ns_.push_back((now_ns() - begin - reading_cost_ns()) / static_cast<double>(kProblemsAtATime));
    }
    repeat_slowest();
  }

  void report(Report& report, double aim_ns) {
    const std::string name = fmt::format("profile_{}_{}", axes_, axes_ == 1 ? "axis" : "axes");
    report.add({name, "time_per_plan", "ns", summarize(std::move(each_ns_)), aim_ns, std::nullopt});
    report.add({name, "mean_of_64_plans", "ns", summarize(std::move(batch_ns_)), std::nullopt, std::nullopt});
    report.add({name, "slowest_repeated", "ns", summarize(std::move(slowest_ns_)), std::nullopt, std::nullopt});
    const double failures = static_cast<double>(failures_);
    report.add({name, "failures", "", {problems_, failures, failures, failures, failures}, 0.0, std::nullopt});
    report.note(fmt::format("{}: slowest problem when repeated {:.0f} ns: {}", name, worst_ns_, worst_));
    if (failures_ > 0) {
      report.note(
          fmt::format("{}: {} of {} without a correct profile, the first: {}", name, failures_, problems_, failed_));
    }
  }

  [[nodiscard]] std::size_t failures() const noexcept { return failures_; }

 private:
  using Problem = std::span<const AxisMotion>;

  [[nodiscard]] Problem problem(const std::vector<AxisMotion>& batch, std::size_t i) const noexcept {
    return Problem(batch).subspan(i * axes_, axes_);
  }

  [[nodiscard]] static std::string describe(Problem problem) {
    std::string all;
    for (const AxisMotion& motion : problem) {
      all += (all.empty() ? "" : ", ") + text(motion);
    }
    return all;
  }

  bool plan(Problem problem) noexcept {
    if (axes_ == 1) {
      const auto profile = plan_to_position(problem[0].from, problem[0].to, problem[0].limits);
      if (profile) {
        profiles_[0] = *profile;
      }
      return profile.has_value();
    }
    return plan_synchronised(problem, Synchronisation::kTime, std::span(profiles_).first(axes_)).has_value();
  }

  [[nodiscard]] bool is_right(Problem problem) const noexcept {
    const double duration_s = profiles_[0].duration_s();
    for (std::size_t i = 0; i < axes_; ++i) {
      if (!bench::is_right(problem[i], profiles_[i]) ||
          std::abs(profiles_[i].duration_s() - duration_s) > kMet * duration_s) {
        return false;
      }
    }
    return true;
  }

  void measure_one_by_one(const std::vector<AxisMotion>& batch) {
    for (std::size_t i = 0; i < kProblemsAtATime; ++i) {
      const Problem problem = this->problem(batch, i);
      const double begin = now_ns();
      const bool planned = plan(problem);
      const double cost_ns = now_ns() - begin - reading_cost_ns();
      each_ns_.push_back(cost_ns);
      ++problems_;
      if (!planned || !is_right(problem)) {
        if (failures_++ == 0) {
          failed_ = describe(problem);
        }
      }
      remember(problem, cost_ns);
    }
  }

  void remember(Problem problem, double cost_ns) {
    if (slowest_.size() == kSlowest && cost_ns <= slowest_.back().first) {
      return;
    }
    slowest_.emplace_back(cost_ns, std::vector<AxisMotion>(problem.begin(), problem.end()));
    std::sort(slowest_.begin(), slowest_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    slowest_.resize(std::min(slowest_.size(), kSlowest));
  }

  /// Plans the slowest problems again: only problems that are really slow stay slow.
  void repeat_slowest() {
    for (const auto& [cost_ns, problem] : slowest_) {
      std::vector<double> again_ns;
      for (int i = 0; i < kRepetitions; ++i) {
        const double begin = now_ns();
        keep(plan(problem));
        again_ns.push_back(now_ns() - begin - reading_cost_ns());
      }
      slowest_ns_.push_back(summarize(std::move(again_ns)).p50);
      if (slowest_ns_.back() > worst_ns_) {
        worst_ns_ = slowest_ns_.back();
        worst_ = describe(problem);
      }
    }
  }

  std::size_t axes_;
  std::array<Profile, kMaxAxes> profiles_;
  std::vector<double> each_ns_;
  std::vector<double> batch_ns_;
  std::vector<double> slowest_ns_;
  std::vector<std::pair<double, std::vector<AxisMotion>>> slowest_;
  double worst_ns_ = 0.0;
  std::string worst_;
  std::string failed_;
  std::size_t problems_ = 0;
  std::size_t failures_ = 0;
};

}  // namespace

std::size_t add_profile_figures(Report& report, const Options& options) {
  constexpr std::array<std::pair<std::size_t, double>, 3> kAims{{{1, 560.0}, {3, 3000.0}, {7, 8000.0}}};
  std::size_t failures = 0;
  for (const auto& [axes, aim_ns] : kAims) {
    Planning planning(axes);
    planning.measure(options.quick ? kQuick : options.shorter ? kShort : kFull);
    planning.report(report, aim_ns);
    failures += planning.failures();
  }
  return failures;
}

}  // namespace driveline::bench
