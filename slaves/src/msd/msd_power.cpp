// Device control of the drive: hardware enable, state machine, brake, status word.
#include <utility>

#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kControlLocationCia402 = 5;
constexpr std::uint16_t kReferenceSourceCia402 = 7;

/// Modes that show ROT_0 in status bit 14 (MSD manual Tables 12.5, 12.14, 12.18-12.24).
bool shows_standstill(OperationMode mode) noexcept {
  return mode != OperationMode::kNone && mode != OperationMode::kVelocity && mode != OperationMode::kProfileVelocity;
}

/// Modes that show "axis synchronised" in status bit 15 (MSD manual 12.3).
bool shows_synchronism(OperationMode mode) noexcept {
  return mode >= OperationMode::kInterpolatedPosition;
}

/// Modes that show the following error in status bit 13 (MSD manual Table 11.9).
bool shows_following_error(OperationMode mode) noexcept {
  return mode == OperationMode::kProfilePosition || mode == OperationMode::kCyclicSynchronousPosition;
}

}  // namespace

bool MsdDrive::remote() const noexcept {
  return dictionary_.get<std::uint16_t>(kControlLocation) == kControlLocationCia402;
}

bool MsdDrive::references_from_bus() const noexcept {
  return dictionary_.get<std::uint16_t>(kReferenceSource) == kReferenceSourceCia402;
}

bool MsdDrive::power_ready() const noexcept {
  return terminals_.level(Input::kEnpo) && terminals_.level(Input::kIsdsh) && dc_link() &&
         dictionary_.get<std::uint8_t>(kParameterDownload) == 0;
}

OptionCodes MsdDrive::option_codes() const noexcept {
  return {dictionary_.get<std::int16_t>(kQuickStopOption), dictionary_.get<std::int16_t>(kShutdownOption),
          dictionary_.get<std::int16_t>(kDisableOperationOption), dictionary_.get<std::int16_t>(kFaultReactionOption),
          std::chrono::milliseconds(dictionary_.get<std::uint32_t>(kExternalReactionTime))};
}

/// The brake hangs at its output, whatever function that has (P 125): energised it opens.
void MsdDrive::follow_brake_output() noexcept {
  const bool energised = terminals_.controls_brake() ? brake_open_ : terminals_.output(Output::kBrake);
  if (std::exchange(brake_energised_, energised) != energised) brake_since_ = running_time();
}

/// Its lift or close time has passed since the output changed (P 213, P 214).
bool MsdDrive::brake_at_rest() const noexcept {
  const double time_ms = dictionary_.get<float>(brake_energised_ ? kBrakeLiftTime : kBrakeCloseTime);
  return static_cast<double>((running_time() - brake_since_).count()) >= time_ms * 1e6;
}

/// Where the output has another function there is no brake for the drive to wait for.
bool MsdDrive::brake_settled() const noexcept {
  return !terminals_.controls_brake() || brake_at_rest();
}

/// Opens with the power stage and closes before a controlled stop takes the torque away (P 213, P 214).
void MsdDrive::control_brake() noexcept {
  brake_open_ = power_.power_on() && !(power_.powers_off_at_standstill(option_codes()) && motion_.stopped());
  follow_brake_output();
}

ModeControl::Conditions MsdDrive::mode_conditions() const noexcept {
  ModeControl::Conditions conditions;
  conditions.control_word = remote() ? dictionary_.get<std::uint16_t>(kControlWord) : std::uint16_t{0};
  conditions.enabled = power_.motion() == MotionCommand::kFollow && modes_.mode() != OperationMode::kNone &&
                       references_from_bus() && brake_open_ && brake_settled();
  conditions.inputs = terminals_.signals();
  return conditions;
}

void MsdDrive::power_step() noexcept {
  if (settings_changed_) apply_settings();
  if (starting()) {
    start_left_ -= kProcessDataPeriod;
    return;
  }
  if (power_.power_on() && terminals_.level(Input::kEnpo) && terminals_.level(Input::kIsdsh) && !dc_link()) {
    raise(Fault::kDcLinkUndervoltage);
  }
  const OperationMode before = modes_.mode();
  modes_.select();
  // Modes take their position from different objects: what has come with the new mode is for the new mode.
  if (modes_.mode() != before && references_from_bus()) motion_.prepare(setpoints());
  PowerStateMachine::Conditions conditions;
  conditions.control_word = remote() ? dictionary_.get<std::uint16_t>(kControlWord) : std::uint16_t{0};
  conditions.power_ready = power_ready();
  conditions.standstill = power_.motion() == MotionCommand::kFollow
                              ? motion_.standstill()
                              : motion_.stopped() && (brake_open_ || brake_settled()) &&
                                    brake_open_ == !power_.powers_off_at_standstill(option_codes());
  conditions.options = option_codes();
  const bool was_on = power_.power_on();
  power_.step(conditions, kProcessDataPeriod);
  if (power_.power_on() && !was_on) {
    initialise_control_ = true;
    apply_settings();
  }
  control_brake();

  const auto modes = mode_conditions();
  const MotionCommand command = power_.motion() == MotionCommand::kFollow ? modes_.command(modes) : power_.motion();
  motion_.select(command, modes_.source(modes), power_.state() != PowerState::kFaultReactionActive);
  modes_.step(modes, motion_);
}

std::uint16_t MsdDrive::status_word() const noexcept {
  const OperationMode mode = modes_.mode();
  unsigned word = status_bits(power_.state()) | modes_.status_bits(motion_);
  const auto put = [&word](std::uint16_t bit, bool on) { word |= on ? bit : 0U; };
  put(status_word::kVoltageEnabled, dc_link());
  put(status_word::kWarning, warnings_ != 0);
  put(status_word::kRemote, remote());
  put(status_word::kTargetReached, power_.quick_stop_finished());
  put(status_word::kInternalLimit, power_.power_on() && (motion_.limited() || modes_.limited()));
  const bool stopped_by_it = power_.state() >= PowerState::kFaultReactionActive && fault_ == Fault::kFollowingError;
  put(status_word::kFollowingError, shows_following_error(mode) && (following_error_ || stopped_by_it));
  put(status_word::kStandstill, shows_standstill(mode) && motion_.standstill());
  put(status_word::kAxisSynchronised, shows_synchronism(mode) && motion_.synchronised());
  return static_cast<std::uint16_t>(word);
}

}  // namespace driveline::slaves::msd
