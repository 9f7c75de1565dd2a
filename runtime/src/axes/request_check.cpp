#include "axes/request_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/velocity_profile.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
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

/// Checks that a double resolves a position well below an increment.
std::optional<AxisRefusal> check_position(const motion::AxisConfig& axis, std::string_view quantity, double position) {
  const double farthest = motion::farthest_position(axis);
  return check({quantity, "", position, -farthest, farthest});
}

std::optional<AxisRefusal> check_positions(const motion::AxisConfig& axis, const motion::AxisRequest& request) {
  if (!std::isfinite(request.target_si)) return not_a_number("target");
  if (motion::names_position(request.command)) {
    if (auto wrong = check_position(axis, "position", request.target_si)) return wrong;
  }
  if (auto wrong = check_position(axis, "distance", request.distance_si)) return wrong;
  if (auto wrong = check_position(axis, "window", request.window_first_si)) return wrong;
  return check_position(axis, "window", request.window_last_si);
}

std::optional<AxisRefusal> check_target(const motion::AxisConfig& axis, const motion::AxisRequest& request) {
  constexpr double kHighestOverride = 2.0;
  const double fastest = axis.limits.max_velocity;
  switch (request.command) {
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return check({"velocity", "/s", request.target_si, -fastest, fastest});
    case AxisCommand::kSetOverride:
      return check({"override", "-", request.target_si, 0.0, kHighestOverride});
    case AxisCommand::kTorque: {
      // 6071h has 16 bits.
      const double most = axis.rated_torque * std::numeric_limits<std::int16_t>::max() / 1000.0;
      return check({"torque", "torque", request.target_si, -most, most});
    }
    default:
      return check_positions(axis, request);
  }
}

/// Whether the request needs setpoints of the master, which a drive that plans its motions does not follow.
bool needs_setpoints(AxisCommand command) {
  switch (command) {
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kHaltSuperimposed:
    case AxisCommand::kFollow:
    case AxisCommand::kTorque:
    case AxisCommand::kSetOverride:
    case AxisCommand::kSetMode:
    case AxisCommand::kHomeByProbe:
      return true;
    default:
      return false;
  }
}

/// Whether the request makes the master close the control loop with torque setpoints.
bool led_by_torque(const motion::AxisRequest& request) {
  constexpr auto kTorqueMode = static_cast<std::int8_t>(motion::cia402::Mode::kCyclicTorque);
  return request.command == AxisCommand::kTorque ||
         (request.command == AxisCommand::kSetMode && request.mode == kTorqueMode);
}

/// Returns the target position as far as it is known before the motion starts: for motions from standstill and to
/// absolute positions.
std::optional<double> destination(const motion::AxisReport& report, const motion::AxisRequest& request) {
  switch (request.command) {
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kDriveMoveAbsolute:
      return request.target_si;
    case AxisCommand::kHomeByProbe:
      return report.setpoint + request.distance_si;
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kDriveMoveRelative:
      if (report.state != motion::PlcopenState::kStandstill) return std::nullopt;
      return report.setpoint + request.target_si;
    default:
      return std::nullopt;
  }
}

std::optional<AxisRefusal> check_destination(const motion::AxisConfig& axis, const motion::AxisReport& report,
                                             const motion::AxisRequest& request) {
  const auto range = range_of_requests(axis, report);
  const auto to = destination(report, request);
  if (!range || !to) return std::nullopt;
  auto wrong = check({"position", "", *to, range->min, range->max});
  if (wrong) wrong->software_limits = true;
  return wrong;
}

/// Returns `value`, or `otherwise` where the request gives none.
double or_else(double value, double otherwise) {
  return value > 0.0 ? value : otherwise;
}

/// Limits of the motion that the master plans for the request, regardless of its direction.
struct PlanLimits {
  double velocity;
  double acceleration;
  double deceleration;
  double jerk;

  PlanLimits(const motion::AxisConfig& axis, double override_factor, const motion::AxisRequest& request)
      : velocity(std::min(or_else(request.velocity_si, axis.limits.max_velocity) * or_else(override_factor, 1.0),
                          axis.limits.max_velocity)),
        acceleration(or_else(request.acceleration_si, axis.limits.max_acceleration)),
        deceleration(or_else(request.deceleration_si, acceleration)),
        jerk(or_else(request.jerk_si, axis.max_jerk.value_or(std::numeric_limits<double>::infinity()))) {}

  [[nodiscard]] trajectory::ProfileLimits towards(double way) const {
    const double faster = way < 0.0 ? deceleration : acceleration;
    const double slower = way < 0.0 ? acceleration : deceleration;
    return {velocity, -velocity, faster, -slower, jerk};
  }
  /// Upper bound of the distance from rest to rest within the longest duration.
  [[nodiscard]] double reach() const {
    constexpr double kTime = trajectory::kLongestProfileSeconds;
    const double by_velocity = velocity * kTime;
    const double by_acceleration = 0.5 * kTime * kTime / (1.0 / acceleration + 1.0 / deceleration);
    // Four phases of equal duration.
    const double by_jerk = jerk * kTime * kTime * kTime / 32.0;
    return std::min({by_velocity, by_acceleration, by_jerk});
  }
  /// Upper bound of the velocity that is reached from rest within the longest duration.
  [[nodiscard]] double velocity_reach() const {
    constexpr double kTime = trajectory::kLongestProfileSeconds;
    return std::min(acceleration * kTime, jerk * kTime * kTime / 4.0);
  }
};

AxisRefusal too_long(std::string_view per, double reach) {
  AxisRefusal refusal;
  refusal.why = Why::kTooLong;
  refusal.per = per;
  refusal.highest = reach;
  return refusal;
}

/// Checks that the motion, from rest at the present setpoint, lasts no longer than a profile can. The axis itself
/// checks it from its motion in progress.
std::optional<AxisRefusal> check_duration(const motion::AxisConfig& axis, const motion::AxisReport& report,
                                          const motion::AxisRequest& request) {
  // Without limits the axis itself decides.
  if (!(axis.limits.max_velocity > 0.0) || !(axis.limits.max_acceleration > 0.0)) return std::nullopt;
  const PlanLimits limits(axis, report.override_factor, request);
  if (request.command == AxisCommand::kMoveVelocity) {
    const double velocity = request.target_si * or_else(report.override_factor, 1.0);
    auto free = limits.towards(velocity);
    free.max_velocity = axis.limits.max_velocity;
    free.min_velocity = -axis.limits.max_velocity;
    const double most = std::clamp(velocity, -axis.limits.max_velocity, axis.limits.max_velocity);
    if (trajectory::plan_to_velocity({}, most, 0.0, free)) return std::nullopt;
    return too_long("/s", limits.velocity_reach());
  }
  const bool planned_here =
      motion::leads_to_position(request.command) || request.command == AxisCommand::kMoveSuperimposed;
  const auto to = planned_here ? destination(report, request) : std::nullopt;
  if (!to || request.direction != motion::MoveDirection::kNone) return std::nullopt;
  const double way = *to - report.setpoint;
  if (trajectory::plan_to_position({}, {way, 0.0, 0.0}, limits.towards(way))) return std::nullopt;
  return too_long("", limits.reach());
}

}  // namespace

std::optional<trajectory::PositionRange> range_of_requests(const motion::AxisConfig& axis,
                                                           const motion::AxisReport& report) {
  if (!axis.software_limits) return std::nullopt;
  return trajectory::PositionRange{axis.software_limits->min + report.position_offset,
                                   axis.software_limits->max + report.position_offset};
}

std::optional<AxisRefusal> check_request(const motion::AxisConfig& axis, const motion::AxisReport& report,
                                         const motion::AxisRequest& request) {
  if (motion::cia402::by_drive(axis.mode) && needs_setpoints(request.command)) {
    AxisRefusal refusal;
    refusal.why = Why::kPlannedByDrive;
    return refusal;
  }
  if (auto wrong = check_target(axis, request)) return wrong;
  if (auto wrong = check_destination(axis, report, request)) return wrong;
  if (led_by_torque(request) && !(axis.velocity_gain > 0.0)) {
    AxisRefusal refusal;
    refusal.why = Why::kNoVelocityGain;
    return refusal;
  }
  const auto& limits = axis.limits;
  if (auto wrong = check({"velocity", "/s", request.velocity_si, 0.0, limits.max_velocity})) return wrong;
  if (!std::isfinite(request.jerk_si) || request.jerk_si < 0.0) return not_a_number("jerk");
  // For a torque request, `acceleration_si` is the slope in torque per second.
  if (request.command == AxisCommand::kTorque) return std::nullopt;
  if (auto wrong = check({"acceleration", "/s^2", request.acceleration_si, 0.0, limits.max_acceleration})) return wrong;
  if (auto wrong = check({"deceleration", "/s^2", request.deceleration_si, 0.0, limits.max_acceleration})) return wrong;
  return check_duration(axis, report, request);
}

}  // namespace driveline::runtime
