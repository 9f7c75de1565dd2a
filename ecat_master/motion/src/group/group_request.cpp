#include "driveline/motion/group/group_request.hpp"

namespace driveline::motion {

std::string_view to_text(GroupCommand command) noexcept {
  switch (command) {
    case GroupCommand::kEnable:
      return "enable";
    case GroupCommand::kDisable:
      return "disable";
    case GroupCommand::kReset:
      return "reset";
    case GroupCommand::kStop:
      return "stop";
    case GroupCommand::kReleaseStop:
      return "release_stop";
    case GroupCommand::kHalt:
      return "halt";
    case GroupCommand::kInterrupt:
      return "interrupt";
    case GroupCommand::kContinue:
      return "continue";
    case GroupCommand::kSetOverride:
      return "set_override";
    case GroupCommand::kReverse:
      return "reverse";
    case GroupCommand::kForward:
      return "forward";
  }
  return "?";
}

std::string_view to_text(GroupBuffer buffer) noexcept {
  switch (buffer) {
    case GroupBuffer::kAborting:
      return "aborting";
    case GroupBuffer::kBuffered:
      return "buffered";
    case GroupBuffer::kBlending:
      return "blending";
  }
  return "?";
}

std::string_view to_text(GroupState state) noexcept {
  switch (state) {
    case GroupState::kDisabled:
      return "GroupDisabled";
    case GroupState::kStandby:
      return "GroupStandby";
    case GroupState::kMoving:
      return "GroupMoving";
    case GroupState::kStopping:
      return "GroupStopping";
    case GroupState::kErrorStop:
      return "GroupErrorStop";
  }
  return "?";
}

std::string_view to_text(GroupError error) noexcept {
  switch (error) {
    case GroupError::kNone:
      return "no error";
    case GroupError::kNotEnabled:
      return "the group is not enabled";
    case GroupError::kErrorStop:
      return "the group is in GroupErrorStop and must be reset first";
    case GroupError::kStopping:
      return "the group was stopped, and the stop has not been released";
    case GroupError::kNotFinite:
      return "a number is not finite";
    case GroupError::kOverLimit:
      return "an override lies within 0 and 2";
    case GroupError::kNothingToDo:
      return "there is no motion on which the request could act";
    case GroupError::kBadMove:
      return "the move cannot be done";
    case GroupError::kAxisNotEnabled:
      return "an axis is not enabled";
    case GroupError::kAxisMoves:
      return "an axis is not at a standstill";
    case GroupError::kAxisErrorStop:
      return "an axis is in ErrorStop and must be reset first";
    case GroupError::kAxisRefused:
      return "an axis cannot be commanded by the group now";
    case GroupError::kAxisFailed:
      return "an axis has failed";
    case GroupError::kAxisAsked:
      return "a request to one of its axes has stopped the group";
    case GroupError::kResetFailed:
      return "an axis could not be reset";
  }
  return "?";
}

}  // namespace driveline::motion
