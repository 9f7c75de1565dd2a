// Torque control of a single axis.
#include <algorithm>
#include <limits>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

TorqueRamp::Limits torque_limits(const AxisConfig& config) noexcept {
  return {config.limits.max_velocity, config.limits.max_acceleration, config.velocity_gain};
}

}  // namespace

/// The axis continues its motion until its drive is in CST.
void SingleAxis::begin_torque() noexcept {
  torque_.ramp.permit(axis_->inputs().velocity);
  if (torque_.phase != Torque::kNone) return;
  mode_change_.return_to = axis_->mode();
  static_cast<void>(axis_->set_mode(cia402::Mode::kCyclicTorque));  // refusal_of_torque() has checked it
  torque_.phase = Torque::kEntering;
  torque_.since = cycle_;
}

/// The ramp starts at the torque that was commanded last.
void SingleAxis::lead_by_torque() noexcept {
  torque_.ramp.start(axis_->target_torque(), axis_->inputs().velocity);
  axis_->command_torque();
  torque_.phase = Torque::kLed;
}

void SingleAxis::enter_torque() noexcept {
  if (axis_->mode_ready()) return lead_by_torque();
  if (exceeded(torque_.since, settings_.mode_timeout)) return give_torque_up(AxisError::kModeTimeout);
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
  const auto limits = torque_limits(axis_->config());
  if (exchange_.good) torque_.ramp.measure(inputs.velocity, period_s_);
  const double step =
      request.acceleration_si > 0.0 ? request.acceleration_si * period_s_ : std::numeric_limits<double>::infinity();
  if (torque_.ramp.advance(request.target_si, step, velocity_of(request), limits, period_s_))
    table_->set(active_->id, {RequestPhase::kReached, AxisError::kNone});
  step_velocity_ = inputs.velocity;
  setpoint_ = {place_under_torque(), inputs.velocity, torque_.ramp.acceleration(),
               torque_.ramp.torque(inputs.velocity, limits)};
  generator_.start_from({setpoint_.position, inputs.velocity, 0.0});
  watch_torque();
}

/// Without a new actual position the last one is extrapolated.
double SingleAxis::place_under_torque() const noexcept {
  const auto& inputs = axis_->inputs();
  return exchange_.good ? inputs.position : setpoint_.position + inputs.velocity * period_s_;
}

void SingleAxis::watch_torque() noexcept {
  const double velocity = axis_->inputs().velocity;
  if (torque_.ramp.too_fast(velocity, torque_limits(axis_->config()), period_s_)) return fail(AxisError::kTooFast);
  if (leaves_range(setpoint_)) fail(AxisError::kOutsideRange);
}

/// The loops of the master take the axis over at its present position and velocity. The part of the torque that does
/// not accelerate the axis stays, and fades.
void SingleAxis::leave_torque() noexcept {
  if (torque_.phase == Torque::kNone) return;
  if (torque_.phase == Torque::kLed) {
    const double torque = setpoint_.torque.value_or(0.0);
    axis_->take_over_torque(torque - axis_->config().inertia * torque_.ramp.acceleration());
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
  torque_.phase = Torque::kNone;
  if (!axis_->enabled() || !mode_change_.return_to) return;
  static_cast<void>(change_mode(*mode_change_.return_to));
  mode_change_.return_to.reset();
}

}  // namespace driveline::motion
