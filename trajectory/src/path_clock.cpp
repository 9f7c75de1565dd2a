#include "driveline/trajectory/path_clock.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace driveline::trajectory {
namespace {

/// Factor by which the ramp beyond full speed is less steep than the ramp up to it; leaves room for the acceleration of
/// the path.
constexpr double kGentle = 4.0;

/// Largest magnitudes of velocity and acceleration of a path, per axis.
std::vector<AxisSetpoint> peaks_of(Interpolator& path, std::size_t axes) {
  constexpr int kPoints = 4096;
  std::vector<AxisSetpoint> setpoints(axes);
  std::vector<AxisSetpoint> peaks(axes);
  for (int point = 0; point <= kPoints; ++point) {
    path.evaluate(path.start_s() + path.duration_s() * point / kPoints, setpoints);
    for (std::size_t i = 0; i < axes; ++i) {
      peaks[i].velocity = std::max(peaks[i].velocity, std::abs(setpoints[i].velocity));
      peaks[i].acceleration = std::max(peaks[i].acceleration, std::abs(setpoints[i].acceleration));
    }
  }
  return peaks;
}
}  // namespace

void PathClock::start(double now_s, double path_s, bool running) noexcept {
  running_ = running;
  rate_ = running ? 1.0 : 0.0;
  slope_ = 0.0;
  now_s_ = since_s_ = now_s;
  path_s_ = since_path_s_ = path_s;
}

/// Returns the full catch-up rate while more time is lost than the ramp back to full speed, or one step, makes up for.
double PathClock::wanted_rate(double step) const noexcept {
  if (!running_) return 0.0;
  const double lead = rate_ - 1.0;
  const double on_the_way_back = lead > 0.0 ? lead * (0.5 * lead * kGentle * ramp_s_ + step) : (catch_up_ - 1.0) * step;
  return behind_s_ > on_the_way_back ? catch_up_ : 1.0;
}

/// Moves the rate towards `goal`: below full speed the ramp is as steep as the limits allow, above it gentle.
double PathClock::approached(double goal, double step) const noexcept {
  const bool beyond = rate_ > 1.0 || (rate_ == 1.0 && goal > 1.0);
  const double most = step / (beyond ? kGentle * ramp_s_ : ramp_s_);
  const double via = rate_ < 1.0 ? std::min(goal, 1.0) : rate_ > 1.0 ? std::max(goal, 1.0) : goal;
  return rate_ + std::clamp(via - rate_, -most, most);
}

double PathClock::advance(double now_s) noexcept {
  const double step = now_s - now_s_;
  now_s_ = now_s;
  slope_ = 0.0;
  const double before = rate_;
  const double goal = wanted_rate(step);
  if (before == goal && before <= 1.0) {
    if (running_) path_s_ = since_path_s_ + (now_s - since_s_);
    return path_s_;
  }
  rate_ = approached(goal, step);
  if (step > 0.0) slope_ = (rate_ - before) / step;
  path_s_ += 0.5 * (before + rate_) * step;
  if (before > 1.0 || rate_ > 1.0) behind_s_ -= (0.5 * (before + rate_) - 1.0) * step;
  if (rate_ == 1.0) {
    since_s_ = now_s;
    since_path_s_ = path_s_;
  }
  return path_s_;
}

double path_ramp_s(Interpolator path, std::span<const AxisLimits> limits) {
  constexpr double kShortest = 1e-3;
  constexpr double kLeastShare = 0.25;
  const auto peaks = peaks_of(path, limits.size());
  double ramp = kShortest;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    const double most = limits[i].max_acceleration;
    const double left = std::max(most - peaks[i].acceleration, kLeastShare * most);
    ramp = std::max(ramp, peaks[i].velocity / left);
  }
  return ramp;
}

double path_catch_up_rate(Interpolator path, std::span<const AxisLimits> limits, double ramp_s) {
  constexpr double kHighest = 1.25;
  // Held points follow one another as fast as the limits allow, so there is no reserve.
  if (facts_of(path.method()).continuity == Continuity::kNone) return 1.0;
  const auto peaks = peaks_of(path, limits.size());
  double rate = kHighest;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    // Straight lines: the velocity jumps at the points by as much as the limits allow.
    if (peaks[i].velocity > 0.0 && peaks[i].acceleration == 0.0) return 1.0;
    if (peaks[i].velocity > 0.0) rate = std::min(rate, limits[i].max_velocity / peaks[i].velocity);
    const double left = limits[i].max_acceleration - peaks[i].velocity * kHighest / (kGentle * ramp_s);
    if (peaks[i].acceleration > 0.0) rate = std::min(rate, std::sqrt(std::max(left, 0.0) / peaks[i].acceleration));
  }
  return std::max(rate, 1.0);
}

}  // namespace driveline::trajectory
