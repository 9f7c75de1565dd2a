#include "operation/axis_verdict.hpp"

#include "driveline/runtime/event.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::runtime {
namespace {

/// Lower bound of the uncertainty of the time between a setpoint and the position compared with it, which is two
/// exchanges.
constexpr std::chrono::milliseconds kUnsureTime{5};

}  // namespace

std::optional<EventFacts> axis_verdict(const motion::AxisConfig& axis, const FollowingError& seen,
                                       std::chrono::nanoseconds period) {
  if (!seen.last || seen.last->state == snapshot::AxisState::kUnavailable) return std::nullopt;
  if (seen.samples == 0) return events::AxisNeverEnabled{axis.name, seen.last->status_word, seen.last->state};
  const double allowed = motion::position_tolerance(axis);
  if (seen.last->state != snapshot::AxisState::kOperationEnabled || !(allowed > 0.0)) return std::nullopt;
  const auto unsure = std::max<std::chrono::nanoseconds>(kUnsureTime, 2 * period);
  const double tolerance =
      allowed + std::abs(seen.last->target_velocity) * std::chrono::duration<double>(unsure).count();
  const double error = seen.last->following_error;
  // Written so that NaN counts as off the setpoint.
  if (std::abs(error) <= tolerance) return std::nullopt;
  return events::AxisOffItsSetpoint{events::event_axis(axis), error, tolerance};
}

}  // namespace driveline::runtime
