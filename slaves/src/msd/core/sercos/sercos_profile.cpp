#include "driveline/slaves/msd/core/sercos/sercos_profile.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_bus.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_limits.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_words.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kSetAndEnabled = 3;                     ///< value that starts a procedure command
constexpr std::uint16_t kMoveCommand = 1;                       ///< P 156
constexpr std::uint16_t kFirstModeIndex = 0x2000 + 10000 + 32;  ///< S-0-0032
constexpr double kFraction = 1.0 / 65'536.0;                    ///< P 3100

static_assert(master_control::kStart == 0x2000);

/// Returns the lesser of two windows of which 0 is none; kWindowOff when both are none.
std::uint32_t least_window(std::uint32_t a, std::uint32_t b) noexcept {
  return std::min(a == 0 ? kWindowOff : a, b == 0 ? kWindowOff : b);
}

}  // namespace

void SercosProfile::reset() noexcept {
  states_ = SercosStates{};
  modes_.reset();
  found_fault_.reset();
  start_target_.reset();
  halt_rad_s2_ = 0.0;
  in_place_ = limited_ = reset_asked_ = reset_was_set_ = false;
}

/// Rows of a bus may have the same slots, so the rows are known by their index.
bool SercosProfile::possible_value(const EntryRow& row, std::uint64_t raw) noexcept {
  if (row.index < kFirstModeIndex || row.index >= kFirstModeIndex + kSercosValue.modes.size()) return true;
  return raw == 0 || SercosMode::of(static_cast<std::uint16_t>(raw)).kind != SercosModeKind::kNone;
}

Scaling SercosProfile::initialise_units(std::uint32_t encoder_increments) noexcept {
  scale_ = next_scale_ ? *next_scale_ : SercosScale::preferred(encoder_increments);
  return scale_.scaling;
}

void SercosProfile::complete(MotionSettings& settings) noexcept {
  const double acceleration = settings.scaling.acceleration_rad_s2;
  settings.cycle_by_objects = false;
  const auto cycle_us = dictionary_->get(kSercosValue.control_cycle);
  settings.steps_per_setpoint =
      static_cast<std::uint32_t>(std::max<std::int64_t>(std::chrono::microseconds(cycle_us) / kControlStep, 1));
  settings.quick_stop_rad_s2 = dictionary_->get(kSercosValue.quick_stop_acceleration) * acceleration;
  settings.slow_down_rad_s2 = halt_rad_s2_ > 0.0 ? halt_rad_s2_ : settings.quick_stop_rad_s2;
  settings.speed_feed_forward = share(kValue.speed_feed_forward_scale);
  settings.torque_feed_forward = share(kValue.torque_feed_forward_scale);
  settings.jerk_time_s = dictionary_->get(kValue.jerk_time) * 1e-3;
  settings.position_limited = false;
  settings.range =
      scale_.modulo == 0 ? PositionRangeLimit{} : PositionRangeLimit(0, static_cast<std::int32_t>(scale_.modulo - 1));
  ControllerParameters& controller = settings.controller;
  controller.max_velocity_rad_s =
      std::min(controller.max_velocity_rad_s, speed_limits(*dictionary_, settings.scaling).most());
  const double torque = torque_unit(scale_, settings.rated_torque_nm);
  controller.max_torque_nm =
      std::min(controller.max_torque_nm, torque_limits(*dictionary_, torque, settings.rated_torque_nm).most());
  // P 370 = 2: speed and torque come with every position (line 893).
  const bool external = settings.method == FineInterpolator::Method::kExternal;
  settings.external_speed_feed_forward = settings.external_torque_feed_forward = external;
  // The monitor of the following error has the window of the drive.
  dictionary_->set(kValue.following_error_window, least_window(dictionary_->get(kSercosValue.tracking_limit),
                                                               dictionary_->get(kSercosValue.monitored_difference)));
  dictionary_->set(kValue.following_error_time, std::uint16_t{0});
}

ProfileEffect SercosProfile::written(std::uint16_t slot) noexcept {
  const SercosModeKind kind = modes_.mode().kind;
  const auto setpoint_of = [kind](SercosModeKind mode) {
    return kind == mode ? ProfileEffect::kSetpoint : ProfileEffect::kPrepared;  // for another mode, no segment starts
  };
  switch (slot) {
    case kSercosValue.positioning_control.number:
      modes_.positioning_written();
      return ProfileEffect::kCommand;
    case kSercosValue.control_word.number:
    case kSercosValue.reset_class_1.number:
      return ProfileEffect::kCommand;
    case kSercosValue.position_command.number:
      return setpoint_of(SercosModeKind::kPosition);
    case kSercosValue.velocity_command.number:
    case kSercosValue.additive_velocity.number:
      return setpoint_of(SercosModeKind::kSpeed);
    case kSercosValue.torque_command.number:
    case kSercosValue.additive_torque.number:
      return setpoint_of(SercosModeKind::kTorque);
    case kSercosValue.position_fraction.number:
    case kSercosValue.velocity_feed_forward.number:
    case kSercosValue.acceleration_feed_forward.number:
      return ProfileEffect::kPrepared;
    default:
      return ProfileEffect::kNone;
  }
}

Setpoints SercosProfile::setpoints(const MotionSettings& settings) const noexcept {
  Setpoints setpoints;
  setpoints.position = dictionary_->get(kSercosValue.position_command);
  if (dictionary_->get(kValue.position_format) != 0) {  // P 379 (line 899)
    setpoints.position_fraction = dictionary_->get(kSercosValue.position_fraction) * kFraction;
  }
  setpoints.velocity_rad_s = speed_command(*dictionary_, settings.scaling);
  setpoints.torque_nm =
      torque_command(*dictionary_, torque_unit(scale_, settings.rated_torque_nm), settings.rated_torque_nm);
  if (!settings.external_speed_feed_forward || !modes_.mode().feed_forward) return setpoints;
  const double gain = dictionary_->get(kSercosValue.feed_forward_gain);
  const double acceleration = std::copysign(settings.scaling.acceleration_rad_s2, settings.scaling.velocity_rad_s);
  setpoints.velocity_offset_rad_s =
      gain * dictionary_->get(kSercosValue.velocity_feed_forward) * settings.scaling.velocity_rad_s;
  setpoints.torque_offset_nm = gain * dictionary_->get(kSercosValue.acceleration_feed_forward) * acceleration *
                               settings.feed_forward_inertia_kg_m2;
  return setpoints;
}

bool SercosProfile::takes_fault_reset() noexcept {
  const bool set = dictionary_->get(kSercosValue.reset_class_1) == kSetAndEnabled;
  if (!set || std::exchange(reset_was_set_, set)) {
    reset_was_set_ = set;
    return false;
  }
  const unsigned status = dictionary_->get(kSercosValue.interface_status);
  dictionary_->set(kSercosValue.interface_status,
                   static_cast<std::uint16_t>(status & ~unsigned{interface_status::kModeNotSetUp}));
  return reset_asked_ = true;
}

/// Bit 14 counts in phase 4 alone (line 478); lines 484 and 485 are the other conditions.
bool SercosProfile::live() const noexcept {
  return dictionary_->get(kValue.nmt_state) == static_cast<std::uint8_t>(NetworkState::kOperational) &&
         dictionary_->get(kValue.control_location) == kControlLocationSercos && setpoints_from_bus();
}

OptionCodes SercosProfile::option_codes() const noexcept {
  return {dictionary_->get(kValue.quick_stop_option), dictionary_->get(kValue.shutdown_option),
          dictionary_->get(kValue.disable_operation_option), dictionary_->get(kValue.fault_reaction_option),
          std::chrono::milliseconds(dictionary_->get(kValue.external_reaction_time))};
}

void SercosProfile::step_state(const ProfileConditions& conditions) noexcept {
  const auto control =
      dictionary_->get(kSercosValue.level_control) == 0 ? SercosStates::Control::kEdge : SercosStates::Control::kLevel;
  states_.step({control_word(), conditions.power_ready, conditions.standstill, in_place_, control, option_codes()},
               kProcessDataPeriod);
  if (states_.state() == PowerState::kSwitchedOn) return;
  in_place_ = false;
  start_target_.reset();
}

/// P 2221 has the values of 605Dh: 0 torque off, 1 slow down ramp, 2 quick stop ramp, 3 and 4 limits.
MotionCommand SercosProfile::halt_command() const noexcept {
  return braking_command(dictionary_->get(kValue.halt_option));
}

void SercosProfile::order(bool released, const InputSignals& /*inputs*/, DriveMotion& motion) noexcept {
  if (states_.state() == PowerState::kSwitchedOn) return order_start(released, motion);
  const bool halt = halted();
  const bool enabled = states_.acts() && modes_.mode().kind != SercosModeKind::kNone;
  // A halt has the acceleration that was in force last (line 431).
  if (enabled && !halt) {
    halt_rad_s2_ = modes_.halt_rad_s2(motion);
    motion.adapt(share(kValue.speed_feed_forward_scale), share(kValue.torque_feed_forward_scale), halt_rad_s2_);
  }
  const MotionCommand command = halt ? halt_command() : states_.command();
  motion.select(command, modes_.source(enabled), states_.state() != PowerState::kFaultReactionActive);
  modes_.step(enabled, halt, motion);
  modes_.watch_target(motion);
}

/// State 4: the brake opens; then the axis may go to the setpoint of the master (lines 505-524).
void SercosProfile::order_start(bool released, DriveMotion& motion) noexcept {
  const SercosMode& mode = modes_.mode();
  modes_.step(false, false, motion);
  if (mode.encoder != 0 && dictionary_->get(kSercosValue.encoder_channels[mode.encoder - 1U]) !=
                               dictionary_->get(kSercosValue.position_encoder)) {
    found_fault_ = Fault::kInvalidConfiguration;  // line 884
  }
  const bool moves = mode.kind == SercosModeKind::kPosition && dictionary_->get(kSercosValue.tracking_limit) != 0 &&
                     dictionary_->get(kSercosValue.enable_option) == kMoveCommand;
  motion.select(MotionCommand::kFollow, moves && released ? MotionSource::kProfilePosition : MotionSource::kNone, true);
  if (!released) return;
  if (moves) return move_to_setpoint(motion);
  in_place_ = true;
}

/// MOVE_COMMAND: a setpoint that is further away than P 743 is a fault without motion. Otherwise the axis goes there
/// with P 168[1] and P 2242; with a speed of 0 it never arrives (line 523).
void SercosProfile::move_to_setpoint(DriveMotion& motion) noexcept {
  const MotionSettings& settings = motion.settings();
  const std::int64_t position = motion.position();
  const std::int64_t target = settings.range.nearest(position, dictionary_->get(kSercosValue.position_command));
  const std::int64_t distance = target - position;
  if (std::abs(distance) > std::int64_t{dictionary_->get(kSercosValue.tracking_limit)}) {
    found_fault_ = Fault::kFollowingError;
    return;
  }
  const double speed = dictionary_->get(kSercosValue.jog_speeds[1]) * std::abs(settings.scaling.velocity_rad_s);
  if (start_target_ != target && speed > 0.0) {
    start_target_ = target;
    motion.move_to(target, {speed, settings.quick_stop_rad_s2, settings.quick_stop_rad_s2, settings.jerk_time_s});
    return;
  }
  in_place_ = distance == 0 || (start_target_ == target && motion.movement_finished());
}

void SercosProfile::publish_state(bool dc_link) noexcept {
  state_bits_ = static_cast<std::uint16_t>(drive_status::of(states_.state(), dc_link) |
                                           unsigned{modes_.number()} << drive_status::kModeShift);
  dictionary_->set(kSercosValue.feed_forward_shown, static_cast<std::uint16_t>(modes_.mode().feed_forward ? 1 : 0));
}

void SercosProfile::publish_motion(const StatusFacts& /*facts*/, const DriveMotion& motion) noexcept {
  const bool follows =
      states_.in_control() && motion.command() == MotionCommand::kFollow && motion.source() != MotionSource::kNone;
  dictionary_->set(kSercosValue.status_word,
                   static_cast<std::uint16_t>(state_bits_ | (follows ? drive_status::kFollows : 0U)));
  limited_ = states_.command() != MotionCommand::kOff && motion.limited();
  const double unit = torque_unit(scale_, motion.settings().rated_torque_nm);
  dictionary_->set(kSercosValue.torque_feedback, saturate<std::int16_t>(motion.torque_nm() / unit));
}

}  // namespace driveline::slaves::msd
