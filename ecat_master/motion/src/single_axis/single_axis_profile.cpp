// Movements of a single axis by the profile generator of its drive.
#include <utility>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {

AxisError SingleAxis::refusal_of_profile(const AxisRequest& request) const noexcept {
  const auto mode = drive_mode(request.command);
  const bool ramps = mode != cia402::Mode::kVelocity;  // those of velocity mode are set in the drive (6048h, 6049h)
  const auto& objects = axis_->drive().profile();
  if (!axis_->supports(mode)) return AxisError::kNoSuchMode;
  if (!mode_may_change() || !axis_->can_change(mode)) return AxisError::kMode;
  // Values whose objects are not mapped are set in the drive, so a request must not contain them.
  const bool given = (!(request.velocity_si > 0.0) || (ramps && objects.takes_velocity())) &&
                     (!(request.acceleration_si > 0.0) || (ramps && objects.takes_acceleration())) &&
                     (!(request.deceleration_si > 0.0) || (ramps && objects.takes_deceleration())) &&
                     !(request.jerk_si > 0.0);
  if (!given) return AxisError::kMode;
  if (mode == cia402::Mode::kVelocity && !objects.holds_target(request.target_si)) return AxisError::kVelocityCount;
  if (runs_by_drive(request.command)) return AxisError::kNone;
  // The drive stops at each target ("the velocity is set to 0", MSD manual 12.2.1).
  if (blends(request.buffer)) return AxisError::kMode;
  const double target = drive_target_of(request);
  if (!in_range(target)) return AxisError::kOutsideRange;
  return axis_->holds_target(target) ? AxisError::kNone : AxisError::kTooFar;
}

/// Target in drive positions. A distance starts at the present setpoint, or at the last target if positionings are
/// waiting.
double SingleAxis::drive_target_of(const AxisRequest& request) const noexcept {
  if (request.command == AxisCommand::kDriveMoveAbsolute) return request.target_si - offset_;
  if (!waits_for_drive(request)) return setpoint_.position + request.target_si;
  return (!waiting_.empty() ? waiting_.back().target : drive_.target.position) + request.target_si;
}

/// Whether the request waits for a positioning under way, including one whose end the drive has just reached.
bool SingleAxis::waits_for_drive(const AxisRequest& request) const noexcept {
  const bool positions = drive_.phase != ByDrive::kNone && drive_.phase != ByDrive::kInterrupted && !homes() &&
                         positions_by_drive(drive_.command) && !active_ && power_.phase == Power::kOn;
  return positions && request.buffer == BufferMode::kBuffered && positions_by_drive(request.command);
}

void SingleAxis::take_profile(std::uint64_t id, const AxisRequest& request) noexcept {
  const Move move{id, request, drive_target_of(request)};
  if (waits_for_drive(request)) return static_cast<void>(keep_waiting(move));
  drop_waiting(AxisError::kNone);
  begin_profile(move);
}

void SingleAxis::begin_profile(const Move& move) noexcept {
  const auto command = move.request.command;
  state_ = runs_by_drive(command) ? PlcopenState::kContinuousMotion : PlcopenState::kDiscreteMotion;
  give_to_drive(move);
  if (drive_.phase == ByDrive::kNone) {
    axis_->drive().forget_target();
    return start_by_drive(move.id, command, drive_mode(command));
  }
  finish(drive_.request, RequestPhase::kAborted);
  finish(drive_.next, RequestPhase::kAborted);
  drive_.request = move.id;
  drive_.command = command;
  table_->set(move.id, {RequestPhase::kActive, AxisError::kNone});
  start_profile();
}

/// Sets the process data of the movement.
void SingleAxis::give_to_drive(const Move& move) noexcept {
  const auto& request = move.request;
  const bool velocity = runs_by_drive(request.command);
  drive_.target = {velocity ? setpoint_.position : move.target, velocity ? request.target_si : 0.0, 0.0};
  const auto& limits = axis_->config().limits;
  const double faster = request.acceleration_si > 0.0 ? request.acceleration_si : limits.max_acceleration;
  axis_->drive().profile().set(velocity_of(request), faster,
                               request.deceleration_si > 0.0 ? request.deceleration_si : faster);
  drive_.given_since = cycle_;
}

/// Sends the next target while the drive still moves: "Terminate actual positioning and start next positioning" (MSD
/// manual Table 12.4, bit 5 = 0).
void SingleAxis::give_next_to_drive() noexcept {
  const auto next = waiting_.pop();
  give_to_drive(next);
  drive_.next = next.id;
  axis_->drive().begin_positioning(DriveLink::TargetChange::kBehind);
}

void SingleAxis::begin_next_in_drive() noexcept {
  finish(drive_.request, RequestPhase::kDone);
  drive_.request = std::exchange(drive_.next, 0);
  table_->set(drive_.request, {RequestPhase::kActive, AxisError::kNone});
  drive_.given_since = cycle_;
  enter(ByDrive::kRunning);
}

void SingleAxis::start_profile() noexcept {
  auto& drive = axis_->drive();
  if (drive_.command == AxisCommand::kDriveRun) {
    // Only once the drive is in the mode: without its ramp bits it would run at once.
    drive.begin_velocity_on_ramp(drive_.target.velocity);
  } else if (drive_.command == AxisCommand::kDriveMoveVelocity) {
    drive.begin_velocity();
  } else {
    drive.begin_positioning(DriveLink::TargetChange::kAtOnce);
  }
  drive_.given_since = cycle_;
  enter(ByDrive::kRunning);
}

void SingleAxis::judge_profile() noexcept {
  const auto& inputs = axis_->inputs();
  const bool velocity = runs_by_drive(drive_.command);
  if (velocity && leaves_range({inputs.position, inputs.velocity, 0.0})) {
    finish(drive_.request, RequestPhase::kError, AxisError::kOutsideRange);
    return interrupt_drive();
  }
  if (!velocity && exceeded(drive_.since, settings_.target_timeout)) return fail(AxisError::kTargetTimeout);
  if (!exchange_.good) return;
  switch (axis_->drive().target_progress(time_since(drive_.given_since))) {
    case DriveLink::TargetProgress::kRunning:
      break;
    case DriveLink::TargetProgress::kNext:
      begin_next_in_drive();
      break;
    case DriveLink::TargetProgress::kNotTaken:
      return fail(AxisError::kNoTarget);
    case DriveLink::TargetProgress::kReached:
      if (velocity) return table_->set(drive_.request, {RequestPhase::kReached, AxisError::kNone});
      if (!waiting_.empty()) break;
      axis_->drive().end_request();
      return leave_drive_mode();
  }
  if (!waiting_.empty() && axis_->drive().target_under_way()) give_next_to_drive();
}

}  // namespace driveline::motion
