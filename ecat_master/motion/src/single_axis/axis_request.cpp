#include "driveline/motion/single_axis/axis_request.hpp"

namespace driveline::motion {

std::string_view to_text(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kPower:
      return "power";
    case AxisCommand::kReset:
      return "reset";
    case AxisCommand::kHome:
      return "home";
    case AxisCommand::kStop:
      return "stop";
    case AxisCommand::kReleaseStop:
      return "release_stop";
    case AxisCommand::kHalt:
      return "halt";
    case AxisCommand::kMoveAbsolute:
      return "move_absolute";
    case AxisCommand::kMoveRelative:
      return "move_relative";
    case AxisCommand::kMoveAdditive:
      return "move_additive";
    case AxisCommand::kMoveSuperimposed:
      return "move_superimposed";
    case AxisCommand::kHaltSuperimposed:
      return "halt_superimposed";
    case AxisCommand::kMoveVelocity:
      return "move_velocity";
    case AxisCommand::kFollow:
      return "follow";
    case AxisCommand::kTorque:
      return "torque";
    case AxisCommand::kSetPosition:
      return "set_position";
    case AxisCommand::kSetOverride:
      return "set_override";
    case AxisCommand::kSetMode:
      return "set_mode";
    case AxisCommand::kTouchProbe:
      return "touch_probe";
    case AxisCommand::kAbortTrigger:
      return "abort_trigger";
    case AxisCommand::kHomeByProbe:
      return "home_by_probe";
    case AxisCommand::kDriveMoveAbsolute:
      return "drive_move_absolute";
    case AxisCommand::kDriveMoveRelative:
      return "drive_move_relative";
    case AxisCommand::kDriveMoveVelocity:
      return "drive_move_velocity";
    case AxisCommand::kDriveRun:
      return "drive_run";
  }
  return "?";
}

std::string_view to_text(PlcopenState state) noexcept {
  switch (state) {
    case PlcopenState::kDisabled:
      return "Disabled";
    case PlcopenState::kStandstill:
      return "Standstill";
    case PlcopenState::kHoming:
      return "Homing";
    case PlcopenState::kStopping:
      return "Stopping";
    case PlcopenState::kDiscreteMotion:
      return "DiscreteMotion";
    case PlcopenState::kContinuousMotion:
      return "ContinuousMotion";
    case PlcopenState::kSynchronizedMotion:
      return "SynchronizedMotion";
    case PlcopenState::kErrorStop:
      return "ErrorStop";
  }
  return "?";
}

std::string_view to_text(RequestPhase phase) noexcept {
  switch (phase) {
    case RequestPhase::kUnknown:
      return "unknown";
    case RequestPhase::kWaiting:
      return "waiting";
    case RequestPhase::kActive:
      return "active";
    case RequestPhase::kReached:
      return "reached";
    case RequestPhase::kDone:
      return "done";
    case RequestPhase::kAborted:
      return "aborted";
    case RequestPhase::kError:
      return "error";
  }
  return "?";
}

std::string_view to_text(AxisError error) noexcept {
  switch (error) {
    case AxisError::kNone:
      return "no error";
    case AxisError::kNotEnabled:
      return "the axis is not enabled";
    case AxisError::kErrorStop:
      return "the axis is in ErrorStop and must be reset first";
    case AxisError::kStopping:
      return "the axis was stopped, and the stop has not been released";
    case AxisError::kNotFinite:
      return "a number is not finite, or a magnitude is negative";
    case AxisError::kOverLimit:
      return "a limit of the axis is lower";
    case AxisError::kOutsideRange:
      return "the target is outside the software limits";
    case AxisError::kBufferFull:
      return "too many motions are waiting";
    case AxisError::kNothingToDo:
      return "there is no motion on which the request could act";
    case AxisError::kMode:
      return "the request is not possible in this mode, or the process data lack objects that the mode needs";
    case AxisError::kNoSuchMode:
      return "the drive does not support the required mode (6502h)";
    case AxisError::kNotAtRest:
      return "the axis is not at a standstill";
    case AxisError::kModeTimeout:
      return "the drive has not changed its mode in time";
    case AxisError::kEnableTimeout:
      return "the drive was not enabled in time";
    case AxisError::kResetTimeout:
      return "the fault of the drive did not clear in time";
    case AxisError::kFault:
      return "the drive reports a fault";
    case AxisError::kLost:
      return "the drive does not answer, or has left Operation enabled";
    case AxisError::kMasterAway:
      return "the master was away for too long";
    case AxisError::kPosition:
      return "the actual position is implausible";
    case AxisError::kHoming:
      return "the drive reported a homing error";
    case AxisError::kHomingTimeout:
      return "the drive did not complete homing in time";
    case AxisError::kTooFast:
      return "the axis exceeded its velocity limit";
    case AxisError::kFollowingError:
      return "the following error was outside its window for too long";
    case AxisError::kFollowing:
      return "the setpoints to follow are not feasible";
    case AxisError::kProbeObjects:
      return "the process data lack the touch probe: 60B8h, 60B9h, or the value of its edge (60BAh to 60BDh)";
    case AxisError::kProbe:
      return "the drive did not activate its touch probe";
    case AxisError::kNoEdge:
      return "the touch probe detected no edge within the distance";
    case AxisError::kNoTarget:
      return "the drive has not accepted its target";
    case AxisError::kDirection:
      return "a direction is for positions of an axis that has a modulo";
    case AxisError::kVelocityCount:
      return "object 6042h of the drive cannot represent this velocity with the factor 604Ch";
    case AxisError::kTargetTimeout:
      return "the drive has not reached its target in time";
    case AxisError::kTooLong:
      return "the motion would take longer than 100000 s, the longest that is possible";
    case AxisError::kTooFar:
      return "a position is too far away: the drive, or the axis, cannot count so far";
    case AxisError::kInGroup:
      return "the axis is commanded by its group, which must be disabled first";
    case AxisError::kGantryFollower:
      return "the axis is the follower of a gantry: its leader is commanded";
    case AxisError::kGantry:
      return "a gantry does not support this request: each of its axes would move alone";
    case AxisError::kGantryPartner:
      return "the other axis of its gantry has failed";
    case AxisError::kSkew:
      return "the skew of its gantry exceeded the limit";
  }
  return "?";
}

std::string_view to_text(MoveDirection direction) noexcept {
  switch (direction) {
    case MoveDirection::kNone:
      return "none";
    case MoveDirection::kShortest:
      return "shortest";
    case MoveDirection::kPositive:
      return "positive";
    case MoveDirection::kNegative:
      return "negative";
  }
  return "?";
}

std::string_view to_text(BufferMode mode) noexcept {
  switch (mode) {
    case BufferMode::kAborting:
      return "aborting";
    case BufferMode::kBuffered:
      return "buffered";
    case BufferMode::kBlendingLow:
      return "blending_low";
    case BufferMode::kBlendingPrevious:
      return "blending_previous";
    case BufferMode::kBlendingNext:
      return "blending_next";
    case BufferMode::kBlendingHigh:
      return "blending_high";
  }
  return "?";
}

}  // namespace driveline::motion
