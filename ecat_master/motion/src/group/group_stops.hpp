#pragma once

#include <cstdint>
#include <optional>

#include "driveline/motion/group/group_request.hpp"
#include "single_axis/stop_lane.hpp"

namespace driveline::motion {

/// Requests to a group that go through the lane of stops, with increasing strength.
enum class GroupStop : std::uint8_t { kInterrupt, kHalt, kDisable, kStop };

/// Lane of stops of a group, its only receiver.
using GroupStopLane = StopLane<GroupRequest, GroupStop, 4>;

/// Which stop of the lane a command is; none: it is queued. \rtsafe
[[nodiscard]] constexpr std::optional<GroupStop> group_stop(GroupCommand command) noexcept {
  switch (command) {
    case GroupCommand::kInterrupt:
      return GroupStop::kInterrupt;
    case GroupCommand::kHalt:
      return GroupStop::kHalt;
    case GroupCommand::kDisable:
      return GroupStop::kDisable;
    case GroupCommand::kStop:
      return GroupStop::kStop;
    default:
      return std::nullopt;
  }
}

/// The weakest stop that ends a queued request of this command when it overtakes it; none: no stop does. \rtsafe
[[nodiscard]] constexpr std::optional<GroupStop> ended_by(GroupCommand command) noexcept {
  switch (command) {
    case GroupCommand::kContinue:
    case GroupCommand::kReverse:
    case GroupCommand::kForward:
      return GroupStop::kInterrupt;
    case GroupCommand::kEnable:
      return GroupStop::kDisable;
    case GroupCommand::kReleaseStop:
      return GroupStop::kStop;
    default:
      return std::nullopt;
  }
}

}  // namespace driveline::motion
