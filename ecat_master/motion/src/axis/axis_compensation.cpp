#include "driveline/motion/axis/axis_compensation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "driveline/trajectory/position_profile.hpp"

namespace driveline::motion {
namespace {

/// Rise time of the acceleration of a backlash take-up, s; it defines the jerk.
constexpr double kRiseS = 5e-3;
/// Reverse motion up to these amounts is jitter of setpoints that follow a measurement: a share of the backlash, or
/// increments of the drive.
constexpr double kTrembleShare = 0.01;
constexpr double kTrembleIncrements = 1.5;

/// Delay of a history that is read one cycle after its last entry was written.
double since_last(double delay_cycles) {
  return std::max(delay_cycles - 1.0, 0.0);
}

}  // namespace

trajectory::AxisLimits limits_of_motion(const trajectory::AxisLimits& drive,
                                        const CompensationSettings& compensation) noexcept {
  const auto& bounds = compensation.correction.bounds();
  const bool turns = bounds.gap > 0.0;
  const double take_up = turns ? compensation.take_up_velocity : 0.0;
  const double change = turns ? compensation.take_up_acceleration : 0.0;
  const double velocity = (drive.max_velocity - take_up) / (1.0 + bounds.slope);
  // Mixed term of the second time derivative of drive(axis, forward).
  const double crossing = turns ? 2.0 * take_up / bounds.gap * bounds.gap_slope * velocity : 0.0;
  const double bent = bounds.curvature * velocity * velocity;
  return {velocity, (drive.max_acceleration - change - crossing - bent) / (1.0 + bounds.slope)};
}

AxisCompensation::AxisCompensation(std::shared_ptr<const CompensationSettings> settings, double period_s,
                                   double delay_cycles, double increment)
    : settings_(std::move(settings)),
      period_s_(period_s),
      reversal_(std::max(kTrembleIncrements * increment, kTrembleShare * settings_->correction.bounds().gap)),
      sides_(since_last(delay_cycles)),
      side_velocities_(since_last(delay_cycles)) {
  remember();
}

void AxisCompensation::remember() noexcept {
  sides_.push(side_.position);
  side_velocities_.push(side_.velocity);
}

void AxisCompensation::begin() noexcept {
  shift_ = 0.0;
  homed_ = true;
  tracking_ = false;
}

AxisCompensation::Renamed AxisCompensation::begin(double mark, double called, bool forward, double setpoint) noexcept {
  const auto& correction = settings_->correction;
  const double side = forward ? 1.0 : 0.0;
  const double drive = drive_target(setpoint).position;
  const double place = mark + shift_;
  const double drive_mark = in_force() ? correction.drive(place, side).position - shift_ : mark;
  // Subtract the correction that the table has at the position `called`.
  const double position = drive_mark - (correction.drive(called, side).position - called);
  shift_ = called - position;
  homed_ = true;
  tracking_ = false;
  return {position, correction.axis(drive + shift_, side_.position) - shift_};
}

void AxisCompensation::update(bool delayed) noexcept {
  seen_ = delayed ? trajectory::AxisSetpoint{sides_.followed(), side_velocities_.followed(), 0.0} : side_;
}

double AxisCompensation::axis_position(double drive) const noexcept {
  if (!in_force()) return drive;
  return settings_->correction.axis(drive + shift_, seen_.position) - shift_;
}

double AxisCompensation::axis_velocity(double drive_velocity, double axis_position) const noexcept {
  if (!in_force()) return drive_velocity;
  const double place = axis_position + shift_;
  const double beside = seen_.velocity * settings_->correction.gap(place);
  return (drive_velocity - beside) / settings_->correction.drive(place, seen_.position).slope;
}

AxisCompensation::DriveTarget AxisCompensation::drive_target(double axis_position) const noexcept {
  if (!in_force()) return {axis_position, 1.0, 0.0};
  const double place = axis_position + shift_;
  const auto value = settings_->correction.drive(place, side_.position);
  return {value.position - shift_, value.slope, side_.velocity * settings_->correction.gap(place)};
}

void AxisCompensation::turn(Direction direction) noexcept {
  direction_ = direction;
  const double gap = settings_->correction.bounds().gap;
  if (!(gap > 0.0)) return;
  const double acceleration = settings_->take_up_acceleration / gap;
  const auto limits =
      trajectory::ProfileLimits::symmetric(settings_->take_up_velocity / gap, acceleration, acceleration / kRiseS);
  const double target = direction == Direction::kForward ? 1.0 : 0.0;
  const auto planned = trajectory::plan_to_position(side_, {target, 0.0, 0.0}, limits);
  // The take-up starts within its own limits, so a plan always exists.
  if (!planned) return;
  profile_ = *planned;
  elapsed_s_ = 0.0;
  turning_ = true;
}

void AxisCompensation::step() noexcept {
  if (turning_) {
    elapsed_s_ += period_s_;
    side_ = profile_.evaluate(elapsed_s_);
    turning_ = !profile_.finished(elapsed_s_);
  }
  remember();
}

void AxisCompensation::advance(double setpoint) noexcept {
  if (!tracking_) lowest_ = highest_ = setpoint;
  tracking_ = true;
  lowest_ = std::min(lowest_, setpoint);
  highest_ = std::max(highest_, setpoint);
  const bool up = setpoint > lowest_ + reversal_ && direction_ != Direction::kForward;
  const bool down = setpoint < highest_ - reversal_ && direction_ != Direction::kBackward;
  if (up || down) {
    turn(up ? Direction::kForward : Direction::kBackward);
    lowest_ = highest_ = setpoint;
  }
  step();
}

void AxisCompensation::rest() noexcept {
  tracking_ = false;
  if (std::exchange(turning_, false)) {
    // The next motion takes up the rest, on its own side.
    side_ = {seen_.position, 0.0, 0.0};
    direction_ = Direction::kNone;
    for (std::size_t cycle = 0; cycle < sides_.whole_cycles() + 2; ++cycle) remember();
  }
}

void AxisCompensation::skip(std::int64_t periods) noexcept {
  // Only the last ones remain in the history.
  const auto steps = std::max<std::int64_t>(periods - 1, 0);
  const auto kept = std::min(steps, static_cast<std::int64_t>(sides_.whole_cycles()) + 2);
  if (turning_) elapsed_s_ += period_s_ * static_cast<double>(steps - kept);
  for (std::int64_t period = 0; period < kept; ++period) step();
}

}  // namespace driveline::motion
