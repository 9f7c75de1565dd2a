#include "driveline/trajectory/path_clock.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace driveline::trajectory {

void PathClock::start(double now_s, double path_s, bool running) noexcept {
  running_ = running;
  rate_ = running ? 1.0 : 0.0;
  slope_ = 0.0;
  now_s_ = since_s_ = now_s;
  path_s_ = since_path_s_ = path_s;
}

double PathClock::advance(double now_s) noexcept {
  const double step = now_s - now_s_;
  now_s_ = now_s;
  const double goal = running_ ? 1.0 : 0.0;
  slope_ = 0.0;
  if (rate_ == goal) {
    if (running_) path_s_ = since_path_s_ + (now_s - since_s_);
    return path_s_;
  }
  const double change = std::clamp(goal - rate_, -step / ramp_s_, step / ramp_s_);
  const double before = rate_;
  rate_ += change;
  if (step > 0.0) slope_ = change / step;
  path_s_ += 0.5 * (before + rate_) * step;
  if (rate_ == 1.0) {
    since_s_ = now_s;
    since_path_s_ = path_s_;
  }
  return path_s_;
}

AxisSetpoint PathClock::scaled(const AxisSetpoint& setpoint) const noexcept {
  return {setpoint.position, setpoint.velocity * rate_,
          setpoint.acceleration * rate_ * rate_ + setpoint.velocity * slope_};
}

double path_ramp_s(Interpolator path, std::span<const AxisLimits> limits) {
  constexpr int kPoints = 4096;
  constexpr double kShortest = 1e-3;
  constexpr double kLeastShare = 0.25;
  std::vector<AxisSetpoint> setpoints(limits.size());
  std::vector<AxisSetpoint> peaks(limits.size());
  for (int point = 0; point <= kPoints; ++point) {
    path.evaluate(path.start_s() + path.duration_s() * point / kPoints, setpoints);
    for (std::size_t i = 0; i < peaks.size(); ++i) {
      peaks[i].velocity = std::max(peaks[i].velocity, std::abs(setpoints[i].velocity));
      peaks[i].acceleration = std::max(peaks[i].acceleration, std::abs(setpoints[i].acceleration));
    }
  }
  double ramp = kShortest;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    const double most = limits[i].max_acceleration;
    const double left = std::max(most - peaks[i].acceleration, kLeastShare * most);
    ramp = std::max(ramp, peaks[i].velocity / left);
  }
  return ramp;
}

}  // namespace driveline::trajectory
