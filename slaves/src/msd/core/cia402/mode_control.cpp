#include "driveline/slaves/msd/core/cia402/mode_control.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::milliseconds;

/// Whether the control word of the mode has a halt bit (MSD manual Table 11.5; mode 2: Table 12.8).
bool has_halt(OperationMode mode) noexcept {
  switch (mode) {
    case OperationMode::kProfilePosition:
    case OperationMode::kVelocity:
    case OperationMode::kProfileVelocity:
    case OperationMode::kHoming:
    case OperationMode::kInterpolatedPosition:
      return true;
    default:
      return false;
  }
}

}  // namespace

bool ModeControl::supported(OperationMode mode) noexcept {
  switch (mode) {
    case OperationMode::kNone:
    case OperationMode::kProfilePosition:
    case OperationMode::kVelocity:
    case OperationMode::kProfileVelocity:
    case OperationMode::kHoming:
    case OperationMode::kInterpolatedPosition:
    case OperationMode::kCyclicSynchronousPosition:
    case OperationMode::kCyclicSynchronousVelocity:
    case OperationMode::kCyclicSynchronousTorque:
      return true;
  }
  return false;
}

void ModeControl::select() noexcept {
  const auto wanted = static_cast<OperationMode>(dictionary_->get(kValue.mode));
  if (supported(wanted)) mode_ = wanted;
}

void ModeControl::reset() noexcept {
  *this = ModeControl(*dictionary_);
}

MotionSource ModeControl::source(const Conditions& conditions) const noexcept {
  if (!conditions.enabled) return MotionSource::kNone;
  switch (mode_) {
    case OperationMode::kNone:
      break;
    case OperationMode::kProfilePosition:
    case OperationMode::kHoming:
      return MotionSource::kProfilePosition;
    case OperationMode::kVelocity:
      return MotionSource::kProfileFrequency;
    case OperationMode::kProfileVelocity:
      return MotionSource::kProfileVelocity;
    case OperationMode::kInterpolatedPosition:
      return (conditions.control_word & control_word::kEnableIp) != 0 ? MotionSource::kCyclicPosition
                                                                      : MotionSource::kProfilePosition;
    case OperationMode::kCyclicSynchronousPosition:
      return MotionSource::kCyclicPosition;
    case OperationMode::kCyclicSynchronousVelocity:
      return MotionSource::kCyclicVelocity;
    case OperationMode::kCyclicSynchronousTorque:
      return MotionSource::kCyclicTorque;
  }
  return MotionSource::kNone;
}

/// 605Dh, reaction to halt: 0 torque off, 1 slow down ramp, 2 quick stop ramp, 3 current limit, 4 voltage limit.
MotionCommand ModeControl::command(const Conditions& conditions) const noexcept {
  const bool halt = conditions.enabled && has_halt(mode_) && (conditions.control_word & control_word::kHalt) != 0;
  if (!halt) return MotionCommand::kFollow;
  switch (dictionary_->get(kValue.halt_option)) {
    case 0:
      return MotionCommand::kOff;
    case 1:
      return MotionCommand::kSlowDownRamp;
    case 2:
      return MotionCommand::kQuickStopRamp;
    default:
      return MotionCommand::kTorqueLimit;
  }
}

bool ModeControl::positioning() const noexcept {
  return mode_ == OperationMode::kProfilePosition || mode_ == OperationMode::kHoming ||
         mode_ == OperationMode::kInterpolatedPosition || mode_ == OperationMode::kCyclicSynchronousPosition;
}

GeneratorLimits ModeControl::profile_limits(const DriveMotion& motion) const noexcept {
  const Scaling& scaling = motion.settings().scaling;
  const double velocity_unit = std::abs(scaling.velocity_rad_s);
  const double velocity = std::min(value(kValue.profile_velocity), value(kValue.max_profile_velocity)) * velocity_unit;
  return {std::min(velocity, value(kValue.max_motor_speed) * kRpm),
          value(kValue.profile_acceleration) * scaling.acceleration_rad_s2,
          value(kValue.profile_deceleration) * scaling.acceleration_rad_s2, motion.settings().jerk_time_s};
}

/// Called when the mode starts, or the drive is enabled in it. A movement of the previous mode ends: the axis brakes
/// and stays at standstill until this mode commands a movement.
void ModeControl::enter(const Conditions& conditions, DriveMotion& motion) noexcept {
  entered_ = conditions.enabled ? mode_ : OperationMode::kNone;
  handshake_.reset(conditions.control_word);
  target_ = motion.position();
  ordered_velocity_.reset();
  homing_.interrupt();
  ordered_homing_ = {};
  start_bit_ = (conditions.control_word & control_word::kHomingStart) != 0;
  window_time_ = {};
  speed_time_ = {};
  reached_ = speed_zero_ = slipping_ = limited_ = false;
  if (motion.command() == MotionCommand::kFollow && motion.source() == MotionSource::kProfilePosition) motion.stand();
}

std::int64_t ModeControl::destination(const SetpointHandshake::Setpoint& setpoint, const DriveMotion& motion) noexcept {
  std::int64_t target = target_ + setpoint.target;  // relative: to the previous target (CiA 402)
  if (!setpoint.relative) {
    // Only bits 6 and 7 of 60F2h are used (MSD manual 14.2).
    const auto direction = dictionary_->get(kValue.positioning_option) >> 6U & 3U;
    target = motion.settings().range.destination(std::llrint(motion.position_demand()), setpoint.target,
                                                 static_cast<PositionRangeLimit::Direction>(direction));
  }
  const MotionSettings& s = motion.settings();
  const std::int64_t allowed =
      s.position_limited ? std::clamp<std::int64_t>(target, s.position_min, s.position_max) : target;
  limited_ = allowed != target;
  return allowed;
}

void ModeControl::step_profile_position(const Conditions& conditions, DriveMotion& motion, bool resume) noexcept {
  const bool finished = !halted_ && !resume && motion.movement_finished();
  const auto setpoint = handshake_.step(conditions.control_word, dictionary_->get(kValue.target_position), finished);
  if (setpoint) {
    target_ = destination(*setpoint, motion);
    window_time_ = {};
    reached_ = false;
  }
  if (halted_) return;
  if (setpoint || (resume && handshake_.busy())) motion.move_to(target_, profile_limits(motion));
}

/// "Updates cyclically the objects listed in the table" (MSD manual 12.2.3): applies target, limit and ramps.
void ModeControl::step_profile_velocity(DriveMotion& motion, bool resume) noexcept {
  const auto wanted = dictionary_->get(kValue.target_velocity);
  const double most = value(kValue.max_profile_velocity);
  const double velocity = std::clamp(static_cast<double>(wanted), -most, most);
  limited_ = velocity < wanted || velocity > wanted;
  GeneratorLimits ramps = profile_limits(motion);
  ramps.velocity = most;
  const bool new_target = ordered_velocity_ != wanted;
  const bool same_speed = !(velocity < ordered_speed_ || velocity > ordered_speed_);
  if (!resume && !new_target && same_speed && ramps == ordered_ramps_) return;
  if (new_target) window_time_ = {};
  ordered_velocity_ = wanted;
  ordered_speed_ = velocity;
  ordered_ramps_ = ramps;
  motion.run_at(velocity * motion.settings().scaling.velocity_rad_s, ramps);
}

/// Returns the unit of 6042h and related objects in rad/s of the motor shaft: the velocity unit of the factor group
/// (MSD manual 12.2.2) times 604Ch.
double ModeControl::velocity_mode_unit(const DriveMotion& motion) const noexcept {
  const double numerator = dictionary_->get(kValue.velocity_dimension_numerator);
  const double denominator = dictionary_->get(kValue.velocity_dimension_denominator);
  return motion.settings().scaling.velocity_rad_s * numerator / std::max(denominator, 1.0);
}

/// Ramp function generator of the velocity mode (MSD manual Tables 12.7, 12.8). Bit 4 is not in the manual and has no
/// effect. The minimum velocity applies to every setpoint except zero (ours).
void ModeControl::step_velocity(std::uint16_t control_word, DriveMotion& motion, bool resume) noexcept {
  if ((control_word & control_word::kUnlockRamp) == 0) {
    if (!ordered_velocity_) return;
    ordered_velocity_.reset();
    return motion.freeze();
  }
  const auto setpoint = dictionary_->get(kValue.velocity_setpoint);
  const bool follow = (control_word & control_word::kReferenceRamp) != 0 && setpoint != 0;
  const double low = value(kValue.velocity_min);
  const double magnitude =
      std::clamp(std::abs(static_cast<double>(setpoint)), low, std::max(value(kValue.velocity_max), low));
  const auto wanted = static_cast<std::int32_t>(follow ? std::copysign(std::min(magnitude, 2e9), setpoint) : 0.0);
  limited_ = follow && wanted != setpoint;
  const double unit = velocity_mode_unit(motion);
  const auto rate = [&](Slot<std::uint32_t> change, Slot<std::uint32_t> seconds) {
    return value(change) * std::abs(unit) / std::max(value(seconds), 1.0);
  };
  const GeneratorLimits ramps{1.0, rate(kValue.velocity_acceleration_change, kValue.velocity_acceleration_time),
                              rate(kValue.velocity_deceleration_change, kValue.velocity_deceleration_time),
                              motion.settings().jerk_time_s};
  if (!resume && ordered_velocity_ == wanted && ramps == ordered_ramps_) return;
  ordered_velocity_ = wanted;
  ordered_ramps_ = ramps;
  motion.run_at(wanted * unit, ramps);
}

HomingInputs ModeControl::homing_inputs(const InputSignals& inputs, const DriveMotion& motion) const noexcept {
  const int sign = motion.settings().scaling.inverted ? -1 : 1;
  const double speed = sign * motion.controller().measured_velocity_rad_s();
  HomingInputs homing;
  homing.negative_limit = inputs.negative_limit;
  homing.positive_limit = inputs.positive_limit;
  homing.home_switch = inputs.home_switch;
  homing.position = sign * motion.motor().encoder_count();
  if (const auto index = motion.motor().index_pulse()) homing.index_pulse = sign * *index;
  homing.travel = speed > 0.0 ? 1 : speed < 0.0 ? -1 : 0;
  homing.standstill = motion.movement_finished() && motion.standstill();
  return homing;
}

/// Control word bit 4: the rising edge starts homing, the falling one interrupts it (MSD manual Table 12.13).
void ModeControl::start_homing(const Conditions& conditions, DriveMotion& motion) noexcept {
  const bool start = (conditions.control_word & control_word::kHomingStart) != 0;
  if (start && !start_bit_) {
    homing_.start(dictionary_->get(kValue.homing_method), homing_inputs(conditions.inputs, motion));
  }
  if (!start && start_bit_) homing_.interrupt();
  start_bit_ = start;
}

bool ModeControl::step_homing(const InputSignals& inputs, DriveMotion& motion,
                              std::chrono::nanoseconds time_out) noexcept {
  if (entered_ != OperationMode::kHoming) return false;
  const bool was_running = homing_.running();
  // A halted axis still moves: edges and index pulses that it passes while it brakes count at their positions.
  homing_.step(homing_inputs(inputs, motion), halted_ ? std::chrono::nanoseconds{0} : kControlStep, time_out);
  const auto demand = homing_.demand();
  if (!halted_ && (demand.direction != ordered_homing_.direction || demand.slow != ordered_homing_.slow)) {
    ordered_homing_ = demand;
    const Scaling& scaling = motion.settings().scaling;
    const double speed =
        value(demand.slow ? kValue.homing_speed_zero : kValue.homing_speed_switch) * std::abs(scaling.velocity_rad_s);
    const double limit = value(kValue.homing_acceleration) * scaling.acceleration_rad_s2;
    const int direction = scaling.inverted ? -demand.direction : demand.direction;
    motion.run_at(direction * speed, {1.0, limit, limit, motion.settings().jerk_time_s});
  }
  if (was_running && homing_.state() == HomingSequence::State::kAttained) {
    // "The sum of home offset and home position is the new zero" (MSD manual 12.2.4).
    const Scaling& scaling = motion.settings().scaling;
    const std::int64_t home = scaling.inverted ? -*homing_.home() : *homing_.home();
    motion.set_zero(home + scaling.to_increments(dictionary_->get(kValue.home_offset)));
    target_ = motion.position();
  }
  const bool failed = homing_.state() == HomingSequence::State::kFailed;
  return std::exchange(homing_failed_, failed) != failed && failed;
}

void ModeControl::step(const Conditions& conditions, DriveMotion& motion) noexcept {
  const bool was_halted = halted_;
  halted_ = command(conditions) != MotionCommand::kFollow;
  if ((conditions.enabled ? mode_ : OperationMode::kNone) != entered_) enter(conditions, motion);
  const bool resume = was_halted && !halted_;
  switch (entered_) {
    case OperationMode::kProfilePosition:
      step_profile_position(conditions, motion, resume);
      break;
    case OperationMode::kProfileVelocity:
      if (!halted_) step_profile_velocity(motion, resume);
      break;
    case OperationMode::kVelocity:
      if (!halted_) step_velocity(conditions.control_word, motion, resume);
      break;
    case OperationMode::kHoming:
      if (resume) ordered_homing_ = {};
      start_homing(conditions, motion);
      break;
    default:
      break;
  }
  update_reached(motion);
}

/// The target counts as reached when the axis has been in the window for this time.
void ModeControl::count_window(bool inside, std::uint16_t time_ms) noexcept {
  window_time_ = inside ? window_time_ + kProcessDataPeriod : std::chrono::nanoseconds{0};
  reached_ = inside && window_time_ >= milliseconds(time_ms);
}

/// Cyclic positions come first and need little; they have the window and time 6067h/6068h, as all positions have.
void ModeControl::update_reached(const DriveMotion& motion) noexcept {
  if (entered_ == OperationMode::kNone || motion.source() != MotionSource::kCyclicPosition) {
    return update_reached_otherwise(motion);
  }
  const auto window = dictionary_->get(kValue.position_window);
  const bool inside = !halted_ && (window == kWindowOff || std::abs(motion.distance_to_target()) <= window);
  count_window(inside, dictionary_->get(kValue.position_window_time));
}

/// Evaluates window and time 6067h/6068h for positions, 606Dh/606Eh for speeds, and the speed threshold 606Fh/6070h.
void ModeControl::update_reached_otherwise(const DriveMotion& motion) noexcept {
  const bool position = positioning();
  const bool velocity = mode_ == OperationMode::kProfileVelocity || mode_ == OperationMode::kCyclicSynchronousVelocity;
  const bool profile = motion.source() == MotionSource::kProfilePosition;
  double distance = motion.distance_to_target();
  if (profile) distance = static_cast<double>(target_ - motion.position());
  if (mode_ == OperationMode::kProfileVelocity) distance = ordered_velocity_.value_or(0) - motion.velocity();
  const auto window = position ? dictionary_->get(kValue.position_window) : dictionary_->get(kValue.velocity_window);
  bool inside = entered_ != OperationMode::kNone && !halted_ &&
                ((position && window == kWindowOff) || std::abs(distance) <= window) &&
                (!profile || (motion.movement_finished() && !handshake_.busy()));
  if (mode_ == OperationMode::kCyclicSynchronousTorque) inside = entered_ == mode_ && !motion.limited();
  // In U/f operation the ramp output is compared with the target; the rotor is not measured.
  if (mode_ == OperationMode::kVelocity) {
    inside = entered_ == mode_ && !halted_ && ordered_velocity_ && motion.movement_finished();
  }
  count_window(inside, position   ? dictionary_->get(kValue.position_window_time)
                       : velocity ? dictionary_->get(kValue.velocity_window_time)
                                  : std::uint16_t{0});

  // The rest is shown in profile velocity (3) only. It starts anew when a mode is entered or left, so an entered mode
  // that does not show it need not find it.
  if (entered_ != OperationMode::kNone && entered_ != OperationMode::kProfileVelocity) return;
  const bool slow = std::abs(motion.velocity()) <= dictionary_->get(kValue.velocity_threshold);
  speed_time_ = slow ? speed_time_ + kProcessDataPeriod : std::chrono::nanoseconds{0};
  speed_zero_ = slow && speed_time_ >= milliseconds(dictionary_->get(kValue.velocity_threshold_time));
  const auto max_slippage = dictionary_->get(kValue.max_slippage);
  slipping_ = entered_ != OperationMode::kNone && !halted_ && max_slippage != kWindowOff &&
              std::abs(motion.velocity_demand() - motion.velocity()) > max_slippage;
}

std::uint16_t ModeControl::status_bits_otherwise(const DriveMotion& motion) const noexcept {
  unsigned bits = 0;
  const auto put = [&bits](std::uint16_t bit, bool on) { bits |= on ? bit : 0U; };
  const bool active = entered_ != OperationMode::kNone;
  if (halted_) {
    put(status_word::kTargetReached, motion.stopped());
  } else if (mode_ == OperationMode::kHoming) {
    put(status_word::kTargetReached, active && !homing_.running() && motion.movement_finished() && motion.standstill());
  } else {
    put(status_word::kTargetReached, reached_);
  }
  switch (mode_) {
    case OperationMode::kProfilePosition:
      put(status_word::kSetpointAcknowledge, handshake_.acknowledged());
      break;
    case OperationMode::kProfileVelocity:
      put(status_word::kSpeedZero, speed_zero_);
      put(status_word::kMaxSlippage, slipping_);
      break;
    case OperationMode::kHoming:
      put(status_word::kHomingAttained, homing_.state() == HomingSequence::State::kAttained);
      put(status_word::kHomingError, homing_.state() == HomingSequence::State::kFailed);
      break;
    case OperationMode::kInterpolatedPosition:
      put(status_word::kIpActive, active && !halted_ && motion.source() == MotionSource::kCyclicPosition);
      break;
    case OperationMode::kCyclicSynchronousPosition:
    case OperationMode::kCyclicSynchronousVelocity:
    case OperationMode::kCyclicSynchronousTorque:
      put(status_word::kTargetUsed, active);
      break;
    default:
      break;
  }
  return static_cast<std::uint16_t>(bits);
}

}  // namespace driveline::slaves::msd
