#include "driveline/ecat_master/cyclic/path_source.hpp"

namespace driveline::ecat_master {

PathSource::PathSource(trajectory::Interpolator path, std::span<const trajectory::AxisLimits> limits, LatePolicy late)
    : path_(std::move(path)) {
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
}

bool PathSource::next(const SetpointCycle& cycle, std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  const double time_s = path_.start_s() + clock_.advance(cycle.time_s);
  path_.evaluate(time_s, setpoints);
  for (auto& setpoint : setpoints) setpoint = clock_.scaled(setpoint);
  return !path_.finished(time_s);
}

}  // namespace driveline::ecat_master
