// Movements of a single axis by the profile generator of its drive.
#include "driveline/ecat_master/single_axis/single_axis.hpp"

namespace driveline::ecat_master {
namespace {

cia402::Mode mode_of(AxisCommand command) noexcept {
  return command == AxisCommand::kDriveMoveVelocity ? cia402::Mode::kProfileVelocity : cia402::Mode::kProfilePosition;
}

}  // namespace

AxisError SingleAxis::refusal_of_profile(const AxisRequest& request) const noexcept {
  const auto mode = mode_of(request.command);
  const auto& objects = axis_->profile();
  if (!axis_->supports(mode)) return AxisError::kNoSuchMode;
  if (changing_mode_ || !axis_->can_change(mode)) return AxisError::kMode;
  // What is not mapped is as the drive has it set.
  const bool given = (!(request.velocity > 0.0) || objects.takes_velocity()) &&
                     (!(request.acceleration > 0.0) || objects.takes_acceleration()) &&
                     (!(request.deceleration > 0.0) || objects.takes_deceleration()) && !(request.jerk > 0.0);
  if (!given) return AxisError::kMode;
  if (request.command == AxisCommand::kDriveMoveVelocity) return AxisError::kNone;
  return in_range(drive_target_of(request)) ? AxisError::kNone : AxisError::kOutsideRange;
}

/// As the drive counts.
double SingleAxis::drive_target_of(const AxisRequest& request) const noexcept {
  const bool absolute = request.command == AxisCommand::kDriveMoveAbsolute;
  return absolute ? request.target - offset_ : setpoint_.position + request.target;
}

void SingleAxis::take_profile(std::uint64_t id, const AxisRequest& request) noexcept {
  const bool velocity = request.command == AxisCommand::kDriveMoveVelocity;
  drive_target_ = {velocity ? setpoint_.position : drive_target_of(request), velocity ? request.target : 0.0, 0.0};
  const auto& limits = axis_->config().limits;
  const double faster = request.acceleration > 0.0 ? request.acceleration : limits.max_acceleration;
  axis_->profile().set(velocity_of(request), faster, request.deceleration > 0.0 ? request.deceleration : faster);
  state_ = velocity ? PlcopenState::kContinuousMotion : PlcopenState::kDiscreteMotion;
  if (by_drive_ == ByDrive::kNone) return start_by_drive(id, request.command, mode_of(request.command));
  finish(drive_request_, RequestPhase::kAborted);
  drive_request_ = id;
  drive_command_ = request.command;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  start_profile();
}

void SingleAxis::start_profile() noexcept {
  if (drive_command_ == AxisCommand::kDriveMoveVelocity) {
    profile_.start_velocity(axis_->inputs().status_word);
  } else {
    profile_.start_position();
  }
  axis_->set_command_bits(profile_.command_bits());
  enter(ByDrive::kRunning);
}

void SingleAxis::judge_profile() noexcept {
  const auto& inputs = axis_->inputs();
  const bool velocity = drive_command_ == AxisCommand::kDriveMoveVelocity;
  if (velocity && leaves_range({inputs.position, inputs.velocity, 0.0})) {
    finish(drive_request_, RequestPhase::kError, AxisError::kOutsideRange);
    return interrupt_drive();
  }
  if (!velocity && exceeded(drive_since_, settings_.target_timeout)) return fail(AxisError::kTargetTimeout);
  if (!exchanged_) return;
  switch (profile_.judge(inputs.status_word, driven_for())) {
    case ProfileHandshake::State::kRunning:
      return axis_->set_command_bits(profile_.command_bits());
    case ProfileHandshake::State::kNotTaken:
      return fail(AxisError::kNoTarget);
    case ProfileHandshake::State::kReached:
      if (velocity) return table_->set(drive_request_, {RequestPhase::kReached, AxisError::kNone});
      axis_->set_command_bits(0);
      leave_drive_mode();
      break;
  }
}

}  // namespace driveline::ecat_master
