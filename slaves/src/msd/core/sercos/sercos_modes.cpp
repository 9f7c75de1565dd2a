#include "driveline/slaves/msd/core/sercos/sercos_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "driveline/slaves/msd/core/sercos/sercos_limits.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_words.hpp"

namespace driveline::slaves::msd {
namespace {

using Kind = SercosModeKind;

constexpr double kFullOverride = 10'000.0;  ///< S-0-0108

bool same(double a, double b) noexcept {
  return !(a < b || a > b);
}

}  // namespace

bool SercosModes::select(std::uint16_t control_word, bool live) noexcept {
  const auto number = master_control::mode(control_word);
  const SercosMode wanted = number ? SercosMode::of(dictionary_->get(kSercosValue.modes[*number])) : SercosMode{};
  if (wanted.kind == Kind::kNone) {
    const unsigned status = dictionary_->get(kSercosValue.interface_status);
    if (live)
      dictionary_->set(kSercosValue.interface_status,
                       static_cast<std::uint16_t>(status | interface_status::kModeNotSetUp));
    return false;
  }
  if (wanted == mode_ && *number == number_) return false;
  mode_ = wanted;
  number_ = *number;
  entered_ = false;
  return true;
}

MotionSource SercosModes::source(bool enabled) const noexcept {
  if (!enabled) return MotionSource::kNone;
  switch (mode_.kind) {
    case Kind::kNone:
      break;
    case Kind::kTorque:
      return MotionSource::kCyclicTorque;
    case Kind::kSpeedRamps:
      return MotionSource::kProfileVelocity;
    case Kind::kSpeed:
      return MotionSource::kCyclicVelocity;
    case Kind::kPosition:
      return MotionSource::kCyclicPosition;
    case Kind::kInterpolation:
      return MotionSource::kProfilePosition;
  }
  return MotionSource::kNone;
}

/// A movement of the mode before ends: the axis brakes and stays until this mode commands a movement.
void SercosModes::enter(bool enabled, DriveMotion& motion) noexcept {
  entered_ = enabled;
  has_target_ = false;
  written_ = false;
  target_ = motion.position();
  ordered_ = Order::kNone;
  take_bit_ = (dictionary_->get(kSercosValue.positioning_control) & positioning::kTake) != 0;
  dictionary_->set(kSercosValue.setpoint_acknowledge, std::uint16_t{0});
  if (motion.command() == MotionCommand::kFollow && motion.source() == MotionSource::kProfilePosition) motion.stand();
}

void SercosModes::step(bool enabled, bool halted, DriveMotion& motion) noexcept {
  if (enabled != entered_) enter(enabled, motion);
  if (halted) ordered_ = Order::kNone;  // what was ordered goes on behind the halt (line 432)
  if (!enabled || halted) return;
  if (mode_.kind == Kind::kSpeedRamps) return step_ramps(motion);
  if (mode_.kind != Kind::kInterpolation) return;
  if (carried_ || written_) return step_positioning(motion);
  step_interpolation(motion);
}

/// Orders a movement unless it is in progress.
void SercosModes::order_position(const GeneratorLimits& limits, DriveMotion& motion) noexcept {
  // Without speed the axis stays where it can stop; it goes on when there is one (ours).
  if (!(limits.velocity > 0.0))
    return order_speed(0.0, {1.0, limits.acceleration, limits.deceleration, limits.jerk_time_s}, motion);
  if (ordered_ == Order::kPosition && ordered_position_ == target_ && ordered_limits_ == limits) return;
  ordered_ = Order::kPosition;
  ordered_position_ = target_;
  ordered_limits_ = limits;
  motion.move_to(target_, limits);
}

void SercosModes::order_speed(double velocity_rad_s, const GeneratorLimits& limits, DriveMotion& motion) noexcept {
  if (ordered_ == Order::kSpeed && same(ordered_speed_, velocity_rad_s) && ordered_limits_ == limits) return;
  ordered_ = Order::kSpeed;
  ordered_speed_ = velocity_rad_s;
  ordered_limits_ = limits;
  motion.run_at(velocity_rad_s, limits);
}

/// Returns the limits of the drive's profile: S-0-0259 with the override S-0-0108, S-0-0260, S-0-0359. An acceleration
/// of 0 counts as P 2242 (ours).
GeneratorLimits SercosModes::limits(const DriveMotion& motion) const noexcept {
  const MotionSettings& s = motion.settings();
  const double unit = s.scaling.acceleration_rad_s2;
  const double override = dictionary_->get(kSercosValue.feed_rate_override) / kFullOverride;
  const double velocity = value(kSercosValue.positioning_velocity) * override * std::abs(s.scaling.velocity_rad_s);
  const double up = value(kSercosValue.positioning_acceleration) * unit;
  const double down = value(kSercosValue.positioning_deceleration) * unit;
  const double acceleration = up > 0.0 ? up : s.quick_stop_rad_s2;
  return {std::min(velocity, s.controller.max_velocity_rad_s), acceleration, down > 0.0 ? down : acceleration,
          s.jerk_time_s};
}

double SercosModes::halt_rad_s2(const DriveMotion& motion) const noexcept {
  const MotionSettings& s = motion.settings();
  if (mode_.kind == Kind::kInterpolation) return limits(motion).deceleration;
  const double ramp = value(kSercosValue.speed_deceleration) * s.scaling.acceleration_rad_s2;
  return mode_.kind == Kind::kSpeedRamps && ramp > 0.0 ? ramp : s.quick_stop_rad_s2;
}

/// Mode 0002: the drive reaches the speed by its ramps (lines 865, 938-939).
void SercosModes::step_ramps(DriveMotion& motion) noexcept {
  const MotionSettings& s = motion.settings();
  const auto ramp = [&](Slot<std::uint32_t> slot) {
    const double rate = value(slot) * s.scaling.acceleration_rad_s2;
    return rate > 0.0 ? rate : s.quick_stop_rad_s2;
  };
  order_speed(speed_command(*dictionary_, s.scaling),
              {1.0, ramp(kSercosValue.speed_acceleration), ramp(kSercosValue.speed_deceleration), s.jerk_time_s},
              motion);
}

/// The drive interpolates to S-0-0258, which may change in flight; on an endless axis it takes the short way (line
/// 973).
void SercosModes::step_interpolation(DriveMotion& motion) noexcept {
  const auto wanted = dictionary_->get(kSercosValue.target_position);
  if (!has_target_ || wanted != taken_) {
    const PositionRangeLimit& range = motion.settings().range;
    const auto way =
        range.limited() ? PositionRangeLimit::Direction::kShortest : PositionRangeLimit::Direction::kLinear;
    target_ = range.destination(std::llrint(motion.position_demand()), wanted, way);
    taken_ = wanted;
    has_target_ = true;
  }
  order_position(limits(motion), motion);
}

/// Returns the way of S-0-0393 to an absolute target (lines 1012-1021). Below S-0-0417, or inside S-0-0418, it is the
/// short one whatever the direction.
std::int64_t SercosModes::destination(std::int32_t target, const DriveMotion& motion) const noexcept {
  using Direction = PositionRangeLimit::Direction;
  constexpr std::array kDirections{Direction::kPositive, Direction::kNegative, Direction::kShortest,
                                   Direction::kShortest};
  const PositionRangeLimit& range = motion.settings().range;
  const std::int64_t from = std::llrint(motion.position_demand());
  if (!range.limited()) return range.destination(from, target, Direction::kLinear);
  const std::int64_t near = range.nearest(from, target);
  const bool slow = std::abs(motion.velocity()) < dictionary_->get(kSercosValue.short_way_velocity);
  const bool close = std::abs(near - from) <= std::int64_t{dictionary_->get(kSercosValue.short_way_window)};
  if (slow || close) return near;
  return range.destination(from, target, kDirections[dictionary_->get(kSercosValue.positioning_mode) & 3U]);
}

/// A relative target adds up to the one before, or to the actual position (lines 1002-1006).
void SercosModes::take_target(std::uint16_t control, const DriveMotion& motion) noexcept {
  const std::int32_t command = dictionary_->get(kSercosValue.positioning_command);
  if ((control & positioning::kRelative) == 0) {
    target_ = destination(command, motion);
  } else {
    target_ = ((control & positioning::kFromActual) != 0 ? motion.position() : target_) + command;
  }
  has_target_ = true;
  dictionary_->set(kSercosValue.setpoint_acknowledge, std::uint16_t{1});
}

/// The drive is positioned by S-0-0346. A jog runs at S-0-0259; behind a jog or a halt the axis waits for a new target
/// (both ours).
void SercosModes::step_positioning(DriveMotion& motion) noexcept {
  const std::uint16_t control = dictionary_->get(kSercosValue.positioning_control);
  const bool take = (control & positioning::kTake) != 0;
  const bool was_set = std::exchange(take_bit_, take);
  const bool risen = take && !was_set;
  if (!take) dictionary_->set(kSercosValue.setpoint_acknowledge, std::uint16_t{0});
  const GeneratorLimits most = limits(motion);
  const double speed = std::copysign(most.velocity, motion.settings().scaling.velocity_rad_s);
  const GeneratorLimits ramps{1.0, most.acceleration, most.deceleration, most.jerk_time_s};
  switch (control & positioning::kMotion) {
    case positioning::kJogPositive:
      has_target_ = false;
      return order_speed(speed, ramps, motion);
    case positioning::kJogNegative:
      has_target_ = false;
      return order_speed(-speed, ramps, motion);
    case positioning::kHalt:
      has_target_ = false;
      return order_speed(0.0, ramps, motion);
    default:
      break;
  }
  if (risen) take_target(control, motion);
  if (has_target_) return order_position(most, motion);
  order_speed(0.0, ramps, motion);
  target_ = motion.position();
}

void SercosModes::watch_target(const DriveMotion& motion) noexcept {
  const bool profile = mode_.kind == Kind::kInterpolation;
  const double distance = profile ? static_cast<double>(target_ - motion.position()) : motion.distance_to_target();
  const bool there = entered_ && motion.command() == MotionCommand::kFollow &&
                     (profile ? has_target_ && motion.movement_finished() : mode_.kind == Kind::kPosition) &&
                     std::abs(distance) <= value(kSercosValue.position_window);
  dictionary_->set(kSercosValue.in_position, static_cast<std::uint16_t>(there ? 1 : 0));
  if (profile) dictionary_->set(kSercosValue.active_target, motion.settings().range.wrap(target_));
}

}  // namespace driveline::slaves::msd
