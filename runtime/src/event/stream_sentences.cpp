#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>

#include "event/event_sentence.hpp"

namespace driveline::runtime {
namespace {

/// Returns "axis x: position 120 deg, allowed are -90 deg to 90 deg".
std::string fault_text(const events::EventAxis& axis, const SetpointFault& fault, stream::Refusal reason) {
  using Figure = SetpointFault::Figure;
  const auto* const name = fault.figure == Figure::kPosition       ? "position"
                           : fault.figure == Figure::kAcceleration ? "acceleration"
                           : fault.figure == Figure::kVelocity     ? "velocity"
                                                                   : "velocity from the previous setpoint";
  const auto* const per = fault.figure == Figure::kPosition       ? ""
                          : fault.figure == Figure::kAcceleration ? "/s^2"
                                                                  : "/s";
  const auto figure = [&](double value) {
    return fmt::format("{:.6g} {}{}", axis.unit.from_si(value), axis.unit.name, per);
  };
  auto text = fmt::format("axis {}: {} {}", axis.name, name, figure(fault.value));
  if (reason == stream::Refusal::kNotFinite) return text;
  return fmt::format("{}, allowed are {} to {}", text, figure(fault.lowest), figure(fault.highest));
}

}  // namespace

std::string describe(const StreamPeer& peer) {
  if (peer.process == 0) return fmt::format("the stream of {}", peer.name);
  return fmt::format("stream client \"{}\" (process {}, user {})", peer.name, peer.process, peer.user);
}

std::string EventSentence::operator()(const events::StreamUp& facts) const {
  return fmt::format("live setpoints of {} at {}", fmt::join(facts.axes, ", "), facts.socket);
}

std::string EventSentence::operator()(const events::StreamClientCame& facts) const {
  return fmt::format("{} has {}", describe(facts.peer), fmt::join(facts.axes, ", "));
}

std::string EventSentence::operator()(const events::StreamClientRefused& facts) const {
  auto text = fmt::format("{} was rejected: {}", describe(facts.peer), facts.reason);
  if (facts.more > 0) text += fmt::format("; and {} more", facts.more);
  return text;
}

std::string EventSentence::operator()(const events::StreamSetpointRefused& facts) const {
  const auto what =
      facts.fault ? fmt::format(": {}", fault_text(facts.axis, *facts.fault, facts.reason)) : std::string{};
  return fmt::format("a setpoint of {} is {}{}; the status of the client counts such setpoints", describe(facts.peer),
                     to_text(facts.reason), what);
}

std::string EventSentence::operator()(const events::StreamStarved& facts) const {
  return fmt::format("{} has no setpoints left: its axes come to rest until more arrive", describe(facts.peer));
}

std::string EventSentence::operator()(const events::StreamClientLeft& facts) const {
  auto text = fmt::format("{} has ended, {}: {} setpoints", describe(facts.peer), to_text(facts.reason), facts.taken);
  for (std::size_t i = 0; i < facts.refused.size(); ++i) {
    if (facts.refused[i] == 0) continue;
    text += fmt::format(", {} {}", facts.refused[i], to_text(static_cast<stream::Refusal>(i)));
  }
  if (facts.starved > 0) text += fmt::format(", ran out {} times", facts.starved);
  // A client over DDS keeps its leases.
  return text + (facts.peer.process == 0 ? "; its axes stay at standstill" : "; its axes are free");
}

}  // namespace driveline::runtime
