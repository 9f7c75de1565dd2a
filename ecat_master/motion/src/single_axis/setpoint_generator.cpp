#include "driveline/motion/single_axis/setpoint_generator.hpp"

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/velocity_profile.hpp"

namespace driveline::motion {

void SetpointGenerator::start_from(const trajectory::AxisSetpoint& state) noexcept {
  state_ = state;
  take(trajectory::Profile(state));
}

bool SetpointGenerator::to_position(const trajectory::AxisSetpoint& to,
                                    const trajectory::ProfileLimits& limits) noexcept {
  const auto planned = trajectory::plan_to_position(state_, to, limits);
  if (planned) take(*planned);
  return planned.has_value();
}

bool SetpointGenerator::to_velocity(double velocity, const trajectory::ProfileLimits& limits) noexcept {
  const auto planned = trajectory::plan_to_velocity(state_, velocity, 0.0, limits);
  if (planned) take(*planned);
  return planned.has_value();
}

const trajectory::AxisSetpoint& SetpointGenerator::advance(double period_s) noexcept {
  elapsed_s_ += period_s;
  if (next_ && profile_.finished(elapsed_s_)) {
    elapsed_s_ -= profile_.duration_s();
    profile_ = *next_;
    next_.reset();
  }
  state_ = profile_.evaluate(elapsed_s_);
  return state_;
}

void SetpointGenerator::take(const trajectory::Profile& profile) noexcept {
  profile_ = profile;
  next_.reset();
  elapsed_s_ = 0.0;
}

}  // namespace driveline::motion
