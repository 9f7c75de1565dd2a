// Sentences of requests to single axes.
#include <fmt/format.h>

#include <cstdint>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/cia402/error_code.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "event/event_sentence.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisError;
using motion::AxisRequest;
using motion::BufferMode;
using Why = AxisRefusal::Why;

std::string length(const events::EventAxis& axis, double value, std::string_view per = "") {
  return fmt::format("{:.6g} {}{}", axis.unit.from_si(value), axis.unit.name, per);
}

std::string_view torque_unit(const events::EventAxis& axis) {
  return axis.unit.kind == trajectory::AxisKind::kLinear ? "N" : "Nm";
}

std::string_view trigger_text(motion::ProbeTrigger trigger) {
  using motion::ProbeTrigger;
  switch (trigger) {
    case ProbeTrigger::kFirstRising:
      return "1, rising edge";
    case ProbeTrigger::kFirstFalling:
      return "1, falling edge";
    case ProbeTrigger::kSecondRising:
      return "2, rising edge";
    case ProbeTrigger::kSecondFalling:
      return "2, falling edge";
    case ProbeTrigger::kZeroPulse:
      break;
  }
  return "zero pulse";
}

/// Returns "1, rising edge, from 10 deg to 20 deg".
std::string probe_text(const events::EventAxis& axis, const AxisRequest& request) {
  auto text = fmt::format(" {}", trigger_text(request.trigger));
  if (request.window_first_si == request.window_last_si) return text;
  return text +
         fmt::format(", from {} to {}", length(axis, request.window_first_si), length(axis, request.window_last_si));
}

/// Returns the text that follows the name of the command.
std::string target_text(const events::EventAxis& axis, const AxisRequest& request) {
  switch (request.command) {
    case AxisCommand::kPower:
      return request.on ? " on" : " off";
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kDriveMoveAbsolute:
      return fmt::format(" to {}", length(axis, request.target_si));
    case AxisCommand::kMoveRelative:
    case AxisCommand::kDriveMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
      return fmt::format(" by {}", length(axis, request.target_si));
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return fmt::format(" {}", length(axis, request.target_si, "/s"));
    case AxisCommand::kTorque:
      return fmt::format(" {:.6g} {}", request.target_si, torque_unit(axis));
    case AxisCommand::kSetPosition:
      return fmt::format(" {}", length(axis, request.target_si));
    case AxisCommand::kSetOverride:
      return fmt::format(" {:.4g} %", 100.0 * request.target_si);
    case AxisCommand::kSetMode:
      return fmt::format(" {}", to_text(static_cast<motion::cia402::Mode>(request.mode)));
    case AxisCommand::kReset:
    case AxisCommand::kHome:
    case AxisCommand::kStop:
    case AxisCommand::kReleaseStop:
    case AxisCommand::kHalt:
    case AxisCommand::kHaltSuperimposed:
    case AxisCommand::kFollow:
    case AxisCommand::kAbortTrigger:
      break;
    case AxisCommand::kTouchProbe:
      return probe_text(axis, request);
    case AxisCommand::kHomeByProbe:
      return fmt::format(" {}, as far as {}, at {}", trigger_text(request.trigger), length(axis, request.distance_si),
                         length(axis, request.target_si));
  }
  return {};
}

/// Returns what to do about the error; empty if the reason is sufficient.
std::string remedy(const events::EventAxis& axis, AxisError error) {
  switch (error) {
    case AxisError::kErrorStop:
      return fmt::format("; `driveline axis {} reset` resets it", axis.name);
    case AxisError::kNotEnabled:
      return "; enable it first";
    case AxisError::kStopping:
      return "; release-stop withdraws it";
    case AxisError::kDirection:
      return "; its [[axis]] has no modulo, or the motion is by a distance";
    case AxisError::kVelocityCount:
      return "; the sdo of its [[slave]] can set another 604Ch";
    default:
      return "";
  }
}

std::string error_text(const events::EventAxis& axis, AxisError error, std::uint16_t code) {
  auto text = std::string(motion::to_text(error));
  if (code != 0) text += fmt::format(" ({})", motion::cia402::error_text(code));
  return text.append(remedy(axis, error));
}

std::string range_reason(const events::EventAxis& axis, double lowest, double highest) {
  return fmt::format("it would leave its software limits, {} to {}", length(axis, lowest), length(axis, highest));
}

std::string skew_text(const events::EventAxis& axis, const GantrySkew& skew) {
  return fmt::format("the skew of its gantry was {}, the limit is {}", length(axis, skew.skew),
                     length(axis, skew.limit));
}

/// Returns the reason why an axis is in ErrorStop.
std::string failure_text(const events::EventAxis& axis, AxisError error, std::uint16_t code,
                         const std::optional<GantrySkew>& skew) {
  const auto& range = axis.software_limits;
  if (error == AxisError::kSkew && skew) return skew_text(axis, *skew);
  return error == AxisError::kOutsideRange && range ? range_reason(axis, range->min, range->max)
                                                    : error_text(axis, error, code);
}

std::string quantity_text(const events::EventAxis& axis, std::string_view per, double value) {
  if (per == "torque") return fmt::format("{:.6g} {}", value, torque_unit(axis));
  return per == "-" ? fmt::format("{:.6g}", value) : length(axis, value, per);
}

std::string reason_of(const events::EventAxis& axis, const AxisRefusal& refusal) {
  switch (refusal.why) {
    case Why::kNotRunning:
      break;
    case Why::kOwned:
      return fmt::format("is commanded by {}", refusal.owner);
    case Why::kMovedTogether:
      return fmt::format("is moved by the {} of this run, together with the other axes; only a stop can be requested",
                         refusal.owner);
    case Why::kNoLease:
      return "the caller does not hold the lease of the axis; acquire the axis first";
    case Why::kProbeTaken:
      return fmt::format("its touch probe is used by {}", refusal.owner);
    case Why::kNotANumber:
      return fmt::format("{} is not a finite number", refusal.quantity);
    case Why::kOutside:
      return fmt::format(
          "{} {} is outside {} to {}{}", refusal.quantity, quantity_text(axis, refusal.per, refusal.value),
          quantity_text(axis, refusal.per, refusal.lowest), quantity_text(axis, refusal.per, refusal.highest),
          refusal.software_limits ? " (min_position, max_position)" : "");
    case Why::kTooLong:
      return fmt::format("the motion would take longer than {} s, the longest that is possible; by then it {} {}",
                         trajectory::kLongestProfileSeconds, refusal.per.empty() ? "covers at most" : "reaches at most",
                         length(axis, refusal.highest, refusal.per));
    case Why::kNoVelocityGain:
      return "torque control needs velocity_gain or inertia in the [[axis]] to limit the velocity";
    case Why::kPlannedByDrive:
      return "the request needs setpoints, but its drive plans its motions itself; move, jog, home, halt and stop are "
             "possible";
    case Why::kTooMany:
      return "too many requests: the request queue of the cycle is full";
    case Why::kNoMaster:
      return fmt::format("it has no master: a [[coupling]] with slave = \"{}\" is expected in the line description",
                         axis.name);
    case Why::kNotCoupled:
      return "it is not coupled to its master";
    case Why::kCoupling:
      if (refusal.coupling == trajectory::CouplingRefusal::kNone)
        return "its master cannot be followed: it has failed, is not enabled, or its position is not known";
      return std::string(to_text(refusal.coupling));
    case Why::kByAxis:
      if (refusal.software_limits) return range_reason(axis, refusal.lowest, refusal.highest);
      if (refusal.error == AxisError::kSkew && refusal.skew) return skew_text(axis, *refusal.skew);
      return error_text(axis, refusal.error, refusal.error_code);
  }
  return "the line is not in operation";
}

}  // namespace

std::string describe(const events::EventAxis& axis, const AxisRequest& request) {
  auto text = fmt::format("{}{}", motion::to_text(request.command), target_text(axis, request));
  const auto add = [&](std::string_view name, double value, std::string_view per) {
    if (value != 0.0) text += fmt::format(", {} {}", name, length(axis, value, per));
  };
  if (request.direction == motion::MoveDirection::kShortest)
    text += ", the shortest way";
  else if (request.direction != motion::MoveDirection::kNone)
    text += fmt::format(", in {} direction", motion::to_text(request.direction));
  add("velocity", request.velocity_si, "/s");
  if (request.command != AxisCommand::kTorque) {
    add("acceleration", request.acceleration_si, "/s^2");
  } else if (request.acceleration_si > 0.0) {
    text += fmt::format(", {:.6g} {}/s", request.acceleration_si, torque_unit(axis));
  }
  add("deceleration", request.deceleration_si, "/s^2");
  add("jerk", request.jerk_si, "/s^3");
  if (request.buffer != BufferMode::kAborting) text += fmt::format(", {}", motion::to_text(request.buffer));
  return text;
}

std::string describe(const events::EventAxis& axis, const AxisRefusal& refusal) {
  return fmt::format("axis {}: {}", axis.name, reason_of(axis, refusal));
}

std::string EventSentence::operator()(const events::AxisRequested& facts) const {
  const auto what = facts.coupling.empty() ? describe(facts.axis, facts.request) : facts.coupling;
  const auto asked = fmt::format("{}: axis {}: {}", facts.who, facts.axis.name, what);
  return facts.refusal ? fmt::format("{}: refused: {}", asked, reason_of(facts.axis, *facts.refusal)) : asked;
}

std::string EventSentence::operator()(const events::AxisRequestFailed& facts) const {
  return fmt::format("{}: axis {}: {}: failed: {}", facts.who, facts.axis.name,
                     facts.coupling.empty() ? describe(facts.axis, facts.request) : facts.coupling,
                     reason_of(facts.axis, facts.refusal));
}

std::string EventSentence::operator()(const events::AxisProbed& facts) const {
  return fmt::format("{}: axis {}: {}: recorded {}", facts.who, facts.axis.name, describe(facts.axis, facts.request),
                     length(facts.axis, facts.position));
}

std::string EventSentence::operator()(const events::CallerRefused& facts) const {
  return fmt::format("{}: refused: {}", facts.who, facts.reason);
}

std::string EventSentence::operator()(const events::AxisLeaseLost& facts) const {
  if (!facts.taken_by.empty()) {
    return fmt::format("axis {}: {} has taken it over from {}", facts.axis, facts.taken_by, facts.owner);
  }
  return fmt::format("axis {}: {} no longer renews its lease: the axis stops", facts.axis, facts.owner);
}

std::string EventSentence::operator()(const events::AxisFailed& facts) const {
  const auto* const others =
      facts.skew ? "it stops with the other axis of its gantry" : "it stops, the other axes continue";
  return fmt::format("axis {}: ErrorStop: {}; {}", facts.axis.name,
                     failure_text(facts.axis, facts.error, facts.error_code, facts.skew), others);
}

std::string EventSentence::operator()(const events::AxisNotReset& facts) const {
  return fmt::format("axis {}: was in ErrorStop at the end: {}", facts.axis.name,
                     failure_text(facts.axis, facts.error, 0, facts.skew));
}

std::string EventSentence::operator()(const events::GantryAskew& facts) const {
  return fmt::format("gantry of {} and {}: the skew is {}, above skew_warning = {}; at {} both axes stop",
                     facts.leader.name, facts.follower, length(facts.leader, facts.skew),
                     length(facts.leader, facts.warning), length(facts.leader, facts.limit));
}

std::string EventSentence::operator()(const events::AxisRestored& facts) const {
  return fmt::format("axis {}: reset", facts.axis);
}

}  // namespace driveline::runtime
