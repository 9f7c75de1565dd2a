// Device control of the drive: hardware enable, brake, and the drive profile between them.
#include "driveline/slaves/msd/core/device_control.hpp"

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {

using std::chrono::nanoseconds;

void DeviceControl::reset() noexcept {
  profile_.reset();
  brake_.want_open(false);
}

bool DeviceControl::power_ready(bool dc_link) const noexcept {
  return enabled_by_hardware() && dc_link && dictionary_->get(kValue.parameter_download) == 0;
}

void DeviceControl::apply_setpoints() noexcept {
  if (profile_.setpoints_from_bus()) motion_->set(profile_.setpoints(motion_->settings()));
}

void DeviceControl::prepare_setpoints() noexcept {
  if (profile_.setpoints_from_bus()) motion_->prepare(profile_.setpoints(motion_->settings()));
}

/// Modes use different position objects: setpoints sent together with a new mode are for this mode.
void DeviceControl::select_mode() noexcept {
  if (profile_.select_mode()) prepare_setpoints();
}

/// Whether the axis is at standstill or a stop has ended, and the brake has settled.
bool DeviceControl::came_to_rest(nanoseconds now) const noexcept {
  if (profile_.command() == MotionCommand::kFollow) return motion_->standstill();
  return motion_->stopped() && (brake_.open() || brake_.settled(now)) &&
         brake_.open() == !profile_.powers_off_at_standstill();
}

bool DeviceControl::step_state(bool dc_link, nanoseconds now) noexcept {
  const bool was_on = profile_.power_on();
  profile_.step_state({power_ready(dc_link), came_to_rest(now)});
  return profile_.power_on() && !was_on;
}

/// The cycle before has applied the commands, so that they would lead to the same state, mode and source again.
bool DeviceControl::steady(bool dc_link, nanoseconds now) const noexcept {
  return profile_.state() == PowerState::kOperationEnabled && power_ready(dc_link) &&
         motion_->follows_cyclic_setpoints() && brake_.rests(now);
}

/// The brake opens with the power stage and closes before a controlled stop removes the torque (P 213, P 214).
void DeviceControl::order(nanoseconds now) noexcept {
  const bool closes = profile_.powers_off_at_standstill() && motion_->stopped();
  brake_.want_open(profile_.power_on() && !closes);
  brake_.follow(now);
  profile_.order(brake_.open() && brake_.settled(now), terminals_->signals(), *motion_);
}

}  // namespace driveline::slaves::msd
