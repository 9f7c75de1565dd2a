#include "driveline/slaves/msd/core/cia402/cia402_profile.hpp"

#include <array>

#include "driveline/slaves/msd/core/cia402/factor_group.hpp"
#include "driveline/slaves/msd/core/control_clock.hpp"
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

/// 60C0h has the numbers of P 370 with inverted sign, except that linear is 0 and none is -1.
constexpr std::int16_t sub_mode(std::uint8_t type) noexcept {
  return type == 0 ? std::int16_t{-1} : type == 1 ? std::int16_t{0} : static_cast<std::int16_t>(-type);
}
constexpr std::uint8_t type_of(std::int16_t mode) noexcept {
  return mode == -1 ? std::uint8_t{0} : mode == 0 ? std::uint8_t{1} : static_cast<std::uint8_t>(-mode);
}

/// Returns the slot of the object that a cyclic mode follows; an invalid slot for the other modes.
constexpr std::uint16_t setpoint_slot(OperationMode mode) noexcept {
  switch (mode) {
    case OperationMode::kInterpolatedPosition:
      return kValue.interpolation_data.number;
    case OperationMode::kCyclicSynchronousPosition:
      return kValue.target_position.number;
    case OperationMode::kCyclicSynchronousVelocity:
      return kValue.target_velocity.number;
    case OperationMode::kCyclicSynchronousTorque:
      return kValue.target_torque.number;
    default:
      return kValue.end();
  }
}

}  // namespace

void Cia402Profile::reset() noexcept {
  power_ = PowerStateMachine{};
  modes_.reset();
  last_control_word_ = 0;
}

bool Cia402Profile::possible_value(const EntryRow& row, std::uint64_t raw) noexcept {
  switch (row.slot) {
    case kValue.mode.number:
      return ModeControl::supported(static_cast<OperationMode>(raw));
    case kValue.homing_method.number:
      return raw == 0 || HomingSequence::supported(static_cast<std::int8_t>(raw));
    default:
      return true;
  }
}

Scaling Cia402Profile::initialise_units(std::uint32_t encoder_increments) noexcept {
  return factor_group(*dictionary_, encoder_increments);
}

ProfileEffect Cia402Profile::written(std::uint16_t slot) noexcept {
  switch (slot) {
    case kValue.control_word.number:
      return ProfileEffect::kCommand;
    case kValue.target_position.number:
    case kValue.target_velocity.number:
    case kValue.target_torque.number:
    case kValue.interpolation_data.number:
      // For another mode, no segment starts.
      return slot == setpoint_slot(modes_.mode()) ? ProfileEffect::kSetpoint : ProfileEffect::kPrepared;
    case kValue.velocity_offset.number:
    case kValue.torque_offset.number:
      return ProfileEffect::kPrepared;
    case kValue.interpolation_type.number:
      dictionary_->set(kValue.interpolation_sub_mode, sub_mode(dictionary_->get(kValue.interpolation_type)));
      return ProfileEffect::kSetting;
    case kValue.interpolation_sub_mode.number:
      dictionary_->set(kValue.interpolation_type, type_of(dictionary_->get(kValue.interpolation_sub_mode)));
      return ProfileEffect::kSetting;
    default:
      return ProfileEffect::kNone;
  }
}

/// Returns 6040h; 0 when the control word does not come from the bus.
std::uint16_t Cia402Profile::control_word() const noexcept {
  return remote() ? dictionary_->get(kValue.control_word) : std::uint16_t{0};
}

OptionCodes Cia402Profile::option_codes() const noexcept {
  return {dictionary_->get(kValue.quick_stop_option), dictionary_->get(kValue.shutdown_option),
          dictionary_->get(kValue.disable_operation_option), dictionary_->get(kValue.fault_reaction_option),
          std::chrono::milliseconds(dictionary_->get(kValue.external_reaction_time))};
}

bool Cia402Profile::select_mode() noexcept {
  const OperationMode before = modes_.mode();
  modes_.select();
  return modes_.mode() != before;
}

void Cia402Profile::step_state(const ProfileConditions& conditions) noexcept {
  power_.step({control_word(), conditions.power_ready, conditions.standstill, option_codes()}, kProcessDataPeriod);
}

void Cia402Profile::order(bool released, const InputSignals& inputs, DriveMotion& motion) noexcept {
  ModeControl::Conditions modes;
  modes.control_word = control_word();
  modes.enabled = power_.motion() == MotionCommand::kFollow && modes_.mode() != OperationMode::kNone &&
                  setpoints_from_bus() && released;
  modes.inputs = inputs;
  const MotionCommand command = power_.motion() == MotionCommand::kFollow ? modes_.command(modes) : power_.motion();
  motion.select(command, modes_.source(modes), power_.state() != PowerState::kFaultReactionActive);
  modes_.step(modes, motion);
}

void Cia402Profile::control(TouchProbe& probe) const noexcept {
  probe.control(static_cast<TouchProbe::Variant>(dictionary_->get(kValue.touch_probe_variant)),
                dictionary_->get(kValue.touch_probe_function));
}

bool Cia402Profile::rests(const TouchProbe& probe) const noexcept {
  return probe.rests(static_cast<TouchProbe::Variant>(dictionary_->get(kValue.touch_probe_variant)),
                     dictionary_->get(kValue.touch_probe_function));
}

void Cia402Profile::fault(bool coast) noexcept {
  power_.fault(option_codes(), coast);
}

bool Cia402Profile::powers_off_at_standstill() const noexcept {
  return power_.powers_off_at_standstill(dictionary_->get(kValue.quick_stop_option));
}

void Cia402Profile::publish_state(bool dc_link) noexcept {
  unsigned word = status_bits(power_.state());
  const auto put = [&word](std::uint16_t bit, bool on) { word |= on ? bit : 0U; };
  put(status_word::kVoltageEnabled, dc_link);
  put(status_word::kRemote, remote());
  put(status_word::kTargetReached, power_.quick_stop_finished());
  state_bits_ = static_cast<std::uint16_t>(word);
  dictionary_->set(kValue.mode_display, static_cast<std::int8_t>(modes_.mode()));
}

void Cia402Profile::publish_motion(const StatusFacts& facts, const DriveMotion& motion) noexcept {
  dictionary_->set(kValue.status_word, static_cast<std::uint16_t>(state_bits_ | motion_bits(facts, motion)));
}

std::uint16_t Cia402Profile::motion_bits(const StatusFacts& facts, const DriveMotion& motion) const noexcept {
  unsigned word = 0;
  const auto put = [&word](std::uint16_t bit, bool on) { word |= on ? bit : 0U; };
  put(status_word::kFollowingError, facts.following_error);
  put(status_word::kStandstill, motion.standstill());
  put(status_word::kAxisSynchronised, motion.synchronised());
  word &= kShownBits[static_cast<std::size_t>(modes_.mode())];
  put(status_word::kWarning, facts.warning);
  put(status_word::kInternalLimit, power_.power_on() && (motion.limited() || modes_.limited()));
  return static_cast<std::uint16_t>(word | modes_.status_bits(motion));
}

}  // namespace driveline::slaves::msd
