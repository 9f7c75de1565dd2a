// Device control of the drive: hardware enable, state machine, brake, status word.
#include "driveline/slaves/msd/core/device_control.hpp"

#include <array>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_settings.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

/// Returns which of bits 13 to 15 of the status word the mode shows: the following error (MSD manual Table 11.9), ROT_0
/// (Tables 12.5, 12.14, 12.18-12.24), "axis synchronised" (12.3).
constexpr std::uint16_t shown_bits(OperationMode mode) noexcept {
  constexpr unsigned kMoving = status_word::kStandstill | status_word::kAxisSynchronised;
  switch (mode) {
    case OperationMode::kNone:
    case OperationMode::kVelocity:
    case OperationMode::kProfileVelocity:
      return 0;
    case OperationMode::kProfilePosition:
      return status_word::kFollowingError | status_word::kStandstill;
    case OperationMode::kHoming:
      return status_word::kStandstill;
    case OperationMode::kCyclicSynchronousPosition:
      return status_word::kFollowingError | kMoving;
    case OperationMode::kInterpolatedPosition:
    case OperationMode::kCyclicSynchronousVelocity:
    case OperationMode::kCyclicSynchronousTorque:
      return kMoving;
  }
  return 0;
}

/// shown_bits() of all modes.
constexpr auto kShownBits = [] {
  std::array<std::uint16_t, static_cast<std::size_t>(OperationMode::kCyclicSynchronousTorque) + 1> bits{};
  for (std::size_t mode = 0; mode < bits.size(); ++mode) bits[mode] = shown_bits(static_cast<OperationMode>(mode));
  return bits;
}();

}  // namespace

using std::chrono::nanoseconds;

void DeviceControl::reset() noexcept {
  power_ = PowerStateMachine{};
  modes_.reset();
  brake_.want_open(false);
}

OptionCodes DeviceControl::option_codes_now() const noexcept {
  return option_codes(*dictionary_);
}

std::int16_t DeviceControl::quick_stop_option() const noexcept {
  return dictionary_->get(kValue.quick_stop_option);
}

bool DeviceControl::power_ready(bool dc_link) const noexcept {
  return enabled_by_hardware() && dc_link && dictionary_->get(kValue.parameter_download) == 0;
}

void DeviceControl::apply_setpoints() noexcept {
  if (references_from_bus(*dictionary_)) motion_->set(setpoints(*dictionary_, modes_.mode()));
}

void DeviceControl::prepare_setpoints() noexcept {
  if (references_from_bus(*dictionary_)) motion_->prepare(setpoints(*dictionary_, modes_.mode()));
}

/// Modes use different position objects: setpoints sent together with a new mode are for this mode.
void DeviceControl::select_mode() noexcept {
  const OperationMode before = modes_.mode();
  modes_.select();
  if (modes_.mode() != before) prepare_setpoints();
}

/// Whether the axis is at standstill or a stop has ended, and the brake has settled.
bool DeviceControl::came_to_rest(nanoseconds now) const noexcept {
  if (power_.motion() == MotionCommand::kFollow) return motion_->standstill();
  return motion_->stopped() && (brake_.open() || brake_.settled(now)) &&
         brake_.open() == !power_.powers_off_at_standstill(quick_stop_option());
}

bool DeviceControl::step_state(bool dc_link, nanoseconds now) noexcept {
  PowerStateMachine::Conditions conditions;
  conditions.control_word = control_word(*dictionary_);
  conditions.power_ready = power_ready(dc_link);
  conditions.standstill = came_to_rest(now);
  conditions.options = option_codes_now();
  const bool was_on = power_.power_on();
  power_.step(conditions, kProcessDataPeriod);
  return power_.power_on() && !was_on;
}

/// The cycle before has applied the commands, so that they would lead to the same state, mode and source again.
bool DeviceControl::steady(bool dc_link, nanoseconds now) const noexcept {
  return power_.state() == PowerState::kOperationEnabled && power_ready(dc_link) &&
         motion_->follows_cyclic_setpoints() && brake_.rests(now);
}

/// Fills the conditions in place: to pack so small a struct into registers costs more than to find its values.
void DeviceControl::find_mode_conditions(nanoseconds now, ModeControl::Conditions& conditions) const noexcept {
  conditions.control_word = control_word(*dictionary_);
  conditions.enabled = power_.motion() == MotionCommand::kFollow && modes_.mode() != OperationMode::kNone &&
                       references_from_bus(*dictionary_) && brake_.open() && brake_.settled(now);
  conditions.inputs = terminals_->signals();
}

/// The brake opens with the power stage and closes before a controlled stop removes the torque (P 213, P 214).
void DeviceControl::order(nanoseconds now) noexcept {
  const bool closes = power_.powers_off_at_standstill(quick_stop_option()) && motion_->stopped();
  brake_.want_open(power_.power_on() && !closes);
  brake_.follow(now);

  ModeControl::Conditions modes;
  find_mode_conditions(now, modes);
  const MotionCommand command = power_.motion() == MotionCommand::kFollow ? modes_.command(modes) : power_.motion();
  motion_->select(command, modes_.source(modes), power_.state() != PowerState::kFaultReactionActive);
  modes_.step(modes, *motion_);
}

bool DeviceControl::step_homing(nanoseconds time_out) noexcept {
  return modes_.step_homing(terminals_->signals(), *motion_, time_out);
}

std::uint16_t DeviceControl::state_bits(bool dc_link) const noexcept {
  unsigned word = status_bits(power_.state());
  const auto put = [&word](std::uint16_t bit, bool on) { word |= on ? bit : 0U; };
  put(status_word::kVoltageEnabled, dc_link);
  put(status_word::kRemote, remote(*dictionary_));
  put(status_word::kTargetReached, power_.quick_stop_finished());
  return static_cast<std::uint16_t>(word);
}

std::uint16_t DeviceControl::motion_bits(const StatusFacts& facts) const noexcept {
  unsigned word = 0;
  const auto put = [&word](std::uint16_t bit, bool on) { word |= on ? bit : 0U; };
  put(status_word::kFollowingError, facts.following_error);
  put(status_word::kStandstill, motion_->standstill());
  put(status_word::kAxisSynchronised, motion_->synchronised());
  word &= kShownBits[static_cast<std::size_t>(modes_.mode())];
  put(status_word::kWarning, facts.warning);
  put(status_word::kInternalLimit, power_.power_on() && (motion_->limited() || modes_.limited()));
  return static_cast<std::uint16_t>(word | modes_.status_bits(*motion_));
}

}  // namespace driveline::slaves::msd
