#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string describe(const StreamPeer& peer) {
  return fmt::format("stream client \"{}\" (process {}, user {})", peer.name, peer.process, peer.user);
}

std::string EventSentence::operator()(const events::StreamUp& facts) const {
  return fmt::format("live setpoints of {} at {}", fmt::join(facts.axes, ", "), facts.socket);
}

std::string EventSentence::operator()(const events::StreamClientCame& facts) const {
  return fmt::format("{} has {}", describe(facts.peer), fmt::join(facts.axes, ", "));
}

std::string EventSentence::operator()(const events::StreamClientRefused& facts) const {
  auto text = fmt::format("{} was sent away: {}", describe(facts.peer), facts.reason);
  if (facts.more > 0) text += fmt::format("; and {} more", facts.more);
  return text;
}

std::string EventSentence::operator()(const events::StreamSetpointRefused& facts) const {
  return fmt::format("a setpoint of {} is {}; its status counts them", describe(facts.peer), to_text(facts.reason));
}

std::string EventSentence::operator()(const events::StreamStarved& facts) const {
  return fmt::format("the setpoints of {} are used up: its axes come to rest until there are more",
                     describe(facts.peer));
}

std::string EventSentence::operator()(const events::StreamClientLeft& facts) const {
  auto text = fmt::format("{} is done, {}: {} setpoints", describe(facts.peer), to_text(facts.reason), facts.taken);
  for (std::size_t i = 0; i < facts.refused.size(); ++i) {
    if (facts.refused[i] == 0) continue;
    text += fmt::format(", {} {}", facts.refused[i], to_text(static_cast<stream::Refusal>(i)));
  }
  if (facts.starved > 0) text += fmt::format(", used up {} times", facts.starved);
  return text + "; its axes are free";
}

}  // namespace driveline::runtime
