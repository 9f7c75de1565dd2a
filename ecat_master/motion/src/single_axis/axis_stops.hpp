#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/motion/single_axis/axis_request.hpp"
#include "single_axis/stop_lane.hpp"

namespace driveline::motion {

/// Requests to an axis that go through the lane of stops, with increasing strength.
enum class AxisStop : std::uint8_t { kHalt, kStop, kPowerOff };

/// Lane of stops of the axes of a line.
using AxisStopLane = StopLane<AxisRequest, AxisStop, 3>;

/// Which stop of the lane a request is; none: it is queued. \rtsafe
[[nodiscard]] constexpr std::optional<AxisStop> axis_stop(const AxisRequest& request) noexcept {
  if (request.command == AxisCommand::kPower && !request.on) return AxisStop::kPowerOff;
  // A buffered stop waits for the end of the motion under way.
  if (request.buffer != BufferMode::kAborting) return std::nullopt;
  if (request.command == AxisCommand::kStop) return AxisStop::kStop;
  if (request.command == AxisCommand::kHalt) return AxisStop::kHalt;
  return std::nullopt;
}

/// The weakest stop that ends a queued request of this command when it overtakes it; none: no stop does. \rtsafe
[[nodiscard]] constexpr std::optional<AxisStop> ended_by(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kPower:
      return AxisStop::kPowerOff;
    case AxisCommand::kReleaseStop:
      return AxisStop::kStop;
    case AxisCommand::kStop:
    case AxisCommand::kHalt:
    case AxisCommand::kReset:
    case AxisCommand::kSetPosition:
    case AxisCommand::kSetOverride:
    case AxisCommand::kSetMode:
    case AxisCommand::kTouchProbe:
    case AxisCommand::kAbortTrigger:
      return std::nullopt;
    default:
      return AxisStop::kHalt;
  }
}

}  // namespace driveline::motion
