// Sentences of events of axes.
#include <fmt/format.h>

#include <cmath>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/cia402/error_code.hpp"
#include "event/event_sentence.hpp"

namespace driveline::runtime {

using motion::AxisPresence;
using motion::LossPolicy;
using Cause = motion::MotionFailure::Cause;

events::EventAxis events::event_axis(const motion::AxisConfig& axis) {
  return {axis.name, motion::position_unit(axis), axis.increments_per_unit, axis.software_limits, axis.modulo};
}

std::string EventSentence::length_text(const events::EventAxis& axis, double length) const {
  auto text = fmt::format("{:.5g} {}", axis.unit.from_si(length), axis.unit.name);
  if (increments_) text += fmt::format(" ({:.0f} increments)", length * axis.increments_per_unit);
  return text;
}

std::string EventSentence::operator()(const events::AxisPresenceChanged& facts) const {
  switch (facts.presence) {
    case AxisPresence::kMissing:
      return fmt::format(
          "axis {}: unavailable; the others {}", facts.axis,
          facts.on_loss == LossPolicy::kHold ? "come to rest on the path and wait for it" : "go on without it");
    case AxisPresence::kEnabling:
      return fmt::format("axis {}: available again, being enabled", facts.axis);
    case AxisPresence::kReturning:
      return fmt::format("axis {}: enabled, returning to the path", facts.axis);
    case AxisPresence::kPresent:
      break;
  }
  return fmt::format("axis {}: back on the path", facts.axis);
}

std::string EventSentence::operator()(const events::AxesStopped& facts) const {
  const auto& name = facts.axis.name;
  const auto& failure = facts.failure;
  switch (failure.cause) {
    case Cause::kAxisFault:
      return fmt::format("axis {}: fault {}, status word 0x{:04X}; all axes stopped{}", name,
                         motion::cia402::error_text(failure.error_code), failure.status_word, cause_text(facts.after));
    case Cause::kAxisLost:
      return fmt::format("axis {}: no longer in operation, status word 0x{:04X}; all axes stopped", name,
                         failure.status_word);
    case Cause::kEnableTimeout:
      return fmt::format("axis {}: did not reach Operation enabled, status word 0x{:04X}, error code {}", name,
                         failure.status_word, motion::cia402::error_text(failure.error_code));
    case Cause::kMasterAway:
      return fmt::format("the master was away for longer than {}; all axes stopped", max_lost_text(facts.limit));
    case Cause::kSetpoint:
      return fmt::format(
          "axis {}: got a setpoint that is outside its limits or not a finite number; all axes stopped within their "
          "limits",
          name);
    case Cause::kTooFast:
      return fmt::format("axis {}: exceeded its velocity limit under the commanded torques; all axes stopped", name);
    case Cause::kFollowingError:
      return fmt::format(
          "axis {}: its following error was {}, outside following_error_window for too long: axis blocked, "
          "overloaded, or commanded too fast; all axes stopped within their limits",
          name, length_text(facts.axis, failure.following_error));
    case Cause::kOutsideRange:
      return range_text(facts);
    case Cause::kPositionLeap:
    case Cause::kPositionFrozen:
    case Cause::kPositionUnsteady:
      return position_text(facts);
    case Cause::kCommunication:
    case Cause::kNone:
      break;
  }
  auto text = std::string("communication lost: the axes exchange no valid process data; quick stop commanded");
  if (!facts.link.empty()) text += "; " + facts.link;
  return text;
}

std::string EventSentence::position_text(const events::AxesStopped& facts) const {
  const auto& name = facts.axis.name;
  const auto& unit = facts.axis.unit;
  const auto& found = facts.failure.position;
  const double ms = found.within_s * 1e3;
  if (facts.failure.cause == Cause::kPositionFrozen) {
    return fmt::format(
        "axis {}: its actual position stayed at {:.6g} {} for {:.4g} ms while its setpoint moved by {}: frozen, or the "
        "axis is blocked; all axes stopped within their limits",
        name, unit.from_si(found.from), unit.name, ms, length_text(facts.axis, found.moved));
  }
  const auto leap = fmt::format("jumped by {} within {:.4g} ms, at most {:.3g} {} are plausible",
                                length_text(facts.axis, found.moved), ms, unit.from_si(found.allowed), unit.name);
  if (facts.failure.cause == Cause::kPositionLeap) {
    return fmt::format("axis {}: its actual position {}: not plausible; all axes stopped within their limits", name,
                       leap);
  }
  return fmt::format("axis {}: was not enabled, its actual position is not steady: it {}", name, leap);
}

std::string EventSentence::range_text(const events::AxesStopped& facts) const {
  const auto range = facts.axis.software_limits.value_or(trajectory::PositionRange{});
  return fmt::format(
      "axis {}: would go to {}; its software limits are {} and {} (min_position, max_position); all axes stopped "
      "within them",
      facts.axis.name, length_text(facts.axis, facts.failure.reaches), length_text(facts.axis, range.min),
      length_text(facts.axis, range.max));
}

std::string EventSentence::operator()(const events::AxesNotOff& facts) const {
  return fmt::format("the axes did not switch off within {} s", facts.waited.count());
}

std::string EventSentence::operator()(const events::AxisNeverEnabled& facts) const {
  return fmt::format("axis {}: never was in Operation enabled, status word 0x{:04X} ({}) at the end", facts.axis,
                     facts.status_word, motion::cia402::to_text(facts.state));
}

std::string EventSentence::operator()(const events::AxisOffItsSetpoint& facts) const {
  const auto& unit = facts.axis.unit;
  return fmt::format(
      "axis {}: ended {} away from its setpoint, position_tolerance is {:.3g} {}: it did not follow its "
      "path",
      facts.axis.name, length_text(facts.axis, std::abs(facts.distance)), unit.from_si(facts.tolerance), unit.name);
}

}  // namespace driveline::runtime
