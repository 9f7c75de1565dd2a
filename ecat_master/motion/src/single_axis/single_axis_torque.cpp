// Torque control of a single axis.
#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

/// Time constant of the acceleration filter, s.
constexpr double kAccelerationFilterS = 5e-3;
/// Factor by which, and time in s for which, an axis may exceed its velocity limit: a velocity is measured late.
constexpr double kSpareVelocity = 1.1;
constexpr double kSpareTimeS = 0.01;
/// Share of max_acceleration that brakes an axis that is faster than torque control permits; the load also acts on it.
constexpr double kBrakingShare = 0.8;

}  // namespace

/// The axis continues its motion until its drive is in CST.
void SingleAxis::begin_torque() noexcept {
  torque_top_ = std::abs(axis_->inputs().velocity);
  if (torque_ != Torque::kNone) return;
  return_mode_ = axis_->mode();
  static_cast<void>(axis_->set_mode(cia402::Mode::kCyclicTorque));  // refusal_of_torque() has checked it
  torque_ = Torque::kEntering;
  torque_since_ = cycle_;
}

/// The ramp starts at the torque that was commanded last.
void SingleAxis::lead_by_torque() noexcept {
  torque_nm_ = axis_->target_torque();
  axis_->command_torque();
  velocity_before_ = axis_->inputs().velocity;
  torque_top_ = std::abs(velocity_before_);
  acceleration_ = 0.0;
  too_fast_s_ = 0.0;
  torque_ = Torque::kLed;
}

void SingleAxis::enter_torque() noexcept {
  if (axis_->mode_ready()) return lead_by_torque();
  if (exceeded(torque_since_, settings_.mode_timeout)) return give_torque_up(AxisError::kModeTimeout);
  if (leaves_range(setpoint_)) give_torque_up(AxisError::kOutsideRange);
}

/// Ends torque control with an error before the drive is in CST.
void SingleAxis::give_torque_up(AxisError error) noexcept {
  finish_move(RequestPhase::kError, error);
  leave_torque();
  begin_move({});
}

void SingleAxis::advance_torque() noexcept {
  const auto& inputs = axis_->inputs();
  const auto& request = active_->request;
  if (exchanged_) {
    acceleration_ += std::min(period_s_ / kAccelerationFilterS, 1.0) *
                     ((inputs.velocity - velocity_before_) / period_s_ - acceleration_);
    velocity_before_ = inputs.velocity;
  }
  const double step =
      request.acceleration_si > 0.0 ? request.acceleration_si * period_s_ : std::numeric_limits<double>::infinity();
  torque_nm_ += std::clamp(request.target_si - torque_nm_, -step, step);
  const double slower = torque_top_ - kBrakingShare * axis_->config().limits.max_acceleration * period_s_;
  torque_top_ = std::max(velocity_of(request), slower);
  if (!(std::abs(request.target_si - torque_nm_) > 0.0))
    table_->set(active_->id, {RequestPhase::kReached, AxisError::kNone});
  step_velocity_ = inputs.velocity;
  setpoint_ = {place_under_torque(), inputs.velocity, acceleration_, within_velocity(torque_nm_)};
  generator_.start_from({setpoint_.position, inputs.velocity, 0.0});
  watch_torque();
}

/// Without a new actual position the last one is extrapolated.
double SingleAxis::place_under_torque() const noexcept {
  const auto& inputs = axis_->inputs();
  return exchanged_ ? inputs.position : setpoint_.position + inputs.velocity * period_s_;
}

/// Reduces the torque so that the axis does not exceed torque_top_; a faster axis is braked no harder than permitted.
double SingleAxis::within_velocity(double torque) const noexcept {
  const double gain = axis_->config().velocity_gain;
  const double velocity = axis_->inputs().velocity;
  return std::clamp(torque, gain * (-torque_top_ - velocity), gain * (torque_top_ - velocity));
}

void SingleAxis::watch_torque() noexcept {
  const auto& config = axis_->config();
  const double velocity = axis_->inputs().velocity;
  const bool too_fast = std::abs(velocity) > kSpareVelocity * config.limits.max_velocity;
  too_fast_s_ = too_fast ? too_fast_s_ + period_s_ : 0.0;
  if (too_fast_s_ > kSpareTimeS) return fail(AxisError::kTooFast);
  if (leaves_range(setpoint_)) fail(AxisError::kOutsideRange);
}

/// The loops of the master take the axis over at its present position and velocity. The part of the torque that does
/// not accelerate the axis stays, and fades.
void SingleAxis::leave_torque() noexcept {
  if (torque_ == Torque::kNone) return;
  if (torque_ == Torque::kLed) {
    const double torque = setpoint_.torque.value_or(0.0);
    axis_->take_over_torque(torque - axis_->config().inertia * acceleration_);
    const double most = axis_->config().limits.max_velocity;
    // One period before the actual position, to which the setpoint of this cycle leads.
    const double velocity = std::clamp(axis_->inputs().velocity, -most, most);
    setpoint_ = {place_under_torque() - velocity * period_s_, velocity, 0.0};
    generator_.start_from(setpoint_);
    step_velocity_ = setpoint_.velocity;
    // Setpoints sent under torque control led nothing: after a gap the axis continues from here.
    supply_.start_from(setpoint_);
    beside_ = false;
    return_motion_.reset();
  }
  torque_ = Torque::kNone;
  if (!axis_->enabled() || !return_mode_) return;
  static_cast<void>(change_mode(*return_mode_));
  return_mode_.reset();
}

}  // namespace driveline::motion
