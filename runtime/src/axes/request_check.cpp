#include "axes/request_check.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace driveline::runtime {
namespace {

using ecat_master::AxisCommand;
using Why = AxisRefusal::Why;

AxisRefusal not_a_number(std::string_view quantity) {
  AxisRefusal refusal;
  refusal.why = Why::kNotANumber;
  refusal.quantity = quantity;
  return refusal;
}

/// A quantity with its permitted range.
struct Ranged {
  std::string_view quantity;
  std::string_view per;
  double value;
  double lowest;
  double highest;
};

std::optional<AxisRefusal> check(const Ranged& ranged) {
  if (!std::isfinite(ranged.value)) return not_a_number(ranged.quantity);
  if (ranged.value >= ranged.lowest && ranged.value <= ranged.highest) return std::nullopt;
  AxisRefusal refusal;
  refusal.why = Why::kOutside;
  refusal.quantity = ranged.quantity;
  refusal.per = ranged.per;
  refusal.value = ranged.value;
  refusal.lowest = ranged.lowest;
  refusal.highest = ranged.highest;
  return refusal;
}

std::optional<AxisRefusal> check_target(const ecat_master::AxisConfig& axis, const ecat_master::AxisRequest& request) {
  constexpr double kHighestOverride = 2.0;
  const double fastest = axis.limits.max_velocity;
  switch (request.command) {
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return check({"velocity", "/s", request.target, -fastest, fastest});
    case AxisCommand::kSetOverride:
      return check({"override", "-", request.target, 0.0, kHighestOverride});
    case AxisCommand::kTorque: {
      // 6071h has 16 bits.
      const double most = axis.rated_torque * std::numeric_limits<std::int16_t>::max() / 1000.0;
      return check({"torque", "torque", request.target, -most, most});
    }
    default:
      if (!std::isfinite(request.target)) return not_a_number("target");
      if (!std::isfinite(request.distance)) return not_a_number("distance");
      if (!std::isfinite(request.window_first) || !std::isfinite(request.window_last)) return not_a_number("window");
      return std::nullopt;
  }
}

/// Whether the request makes the master close the control loop with torque setpoints.
bool led_by_torque(const ecat_master::AxisRequest& request) {
  constexpr auto kTorqueMode = static_cast<std::int8_t>(ecat_master::cia402::Mode::kCyclicTorque);
  return request.command == AxisCommand::kTorque ||
         (request.command == AxisCommand::kSetMode && request.mode == kTorqueMode);
}

/// Returns the target position as far as it is known before the motion starts: for motions from standstill and to
/// absolute positions.
std::optional<double> destination(const ecat_master::AxisReport& report, const ecat_master::AxisRequest& request) {
  switch (request.command) {
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kDriveMoveAbsolute:
      return request.target;
    case AxisCommand::kHomeByProbe:
      return report.setpoint + request.distance;
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kDriveMoveRelative:
      if (report.state != ecat_master::PlcopenState::kStandstill) return std::nullopt;
      return report.setpoint + request.target;
    default:
      return std::nullopt;
  }
}

std::optional<AxisRefusal> check_destination(const ecat_master::AxisConfig& axis, const ecat_master::AxisReport& report,
                                             const ecat_master::AxisRequest& request) {
  const auto range = range_of_requests(axis, report);
  const auto to = destination(report, request);
  if (!range || !to) return std::nullopt;
  auto wrong = check({"position", "", *to, range->min, range->max});
  if (wrong) wrong->software_limits = true;
  return wrong;
}

}  // namespace

std::optional<trajectory::PositionRange> range_of_requests(const ecat_master::AxisConfig& axis,
                                                           const ecat_master::AxisReport& report) {
  if (!axis.software_limits) return std::nullopt;
  return trajectory::PositionRange{axis.software_limits->min + report.position_offset,
                                   axis.software_limits->max + report.position_offset};
}

std::optional<AxisRefusal> check_request(const ecat_master::AxisConfig& axis, const ecat_master::AxisReport& report,
                                         const ecat_master::AxisRequest& request) {
  if (auto wrong = check_target(axis, request)) return wrong;
  if (auto wrong = check_destination(axis, report, request)) return wrong;
  if (led_by_torque(request) && !(axis.velocity_gain > 0.0)) {
    AxisRefusal refusal;
    refusal.why = Why::kNoVelocityGain;
    return refusal;
  }
  const auto& limits = axis.limits;
  if (auto wrong = check({"velocity", "/s", request.velocity, 0.0, limits.max_velocity})) return wrong;
  if (!std::isfinite(request.jerk) || request.jerk < 0.0) return not_a_number("jerk");
  // For a torque request, `acceleration` is the slope in torque per second.
  if (request.command == AxisCommand::kTorque) return std::nullopt;
  if (auto wrong = check({"acceleration", "/s^2", request.acceleration, 0.0, limits.max_acceleration})) return wrong;
  return check({"deceleration", "/s^2", request.deceleration, 0.0, limits.max_acceleration});
}

}  // namespace driveline::runtime
