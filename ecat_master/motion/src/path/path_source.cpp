#include "driveline/motion/path/path_source.hpp"

namespace driveline::motion {

PathSource::PathSource(trajectory::Interpolator path, std::span<const trajectory::AxisLimits> limits, LatePolicy late,
                       std::span<const double> dead_times)
    : path_(std::move(path)) {
  if (!dead_times.empty()) {
    leads_.emplace(dead_times);
    at_delay_.resize(dead_times.size());
  }
  const double ramp_s = trajectory::path_ramp_s(path_, limits);
  const bool catches_up = late == LatePolicy::kCatchUp;
  clock_ = trajectory::PathClock(ramp_s, catches_up ? trajectory::path_catch_up_rate(path_, limits, ramp_s) : 1.0);
}

void PathSource::rewind(std::span<trajectory::AxisSetpoint> first) noexcept {
  path_.evaluate(path_.start_s(), first);
  clock_.be_on_time();
}

void PathSource::begin(bool running) noexcept {
  clock_.start(0.0, 0.0, running);
  if (leads_) leads_->rewind();
}

bool PathSource::next(const SetpointCycle& cycle, std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  const double time_s = path_.start_s() + clock_.advance(cycle.time_s);
  if (leads_) return next_ahead(setpoints);
  path_.evaluate(time_s, setpoints);
  for (auto& setpoint : setpoints) setpoint = clock_.scaled(setpoint);
  return !path_.finished(time_s);
}

/// Evaluates each axis at its own path time. The path ends when the axis with the longest lag has arrived.
bool PathSource::next_ahead(std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  leads_->push(clock_.moment());
  // Start with the longest delay, so that the time rises for the cursor of the path.
  for (std::size_t n = leads_->delays().size(); n-- > 0;) {
    const auto moment = leads_->at(leads_->delays()[n]);
    path_.evaluate(path_.start_s() + moment.path_s, at_delay_);
    for (std::size_t axis = 0; axis < setpoints.size(); ++axis) {
      if (leads_->delay_of(axis) == n) setpoints[axis] = moment.scaled(at_delay_[axis]);
    }
  }
  return !path_.finished(path_.start_s() + leads_->at(leads_->longest()).path_s);
}

}  // namespace driveline::motion
