// Sentences of commands over DDS.
#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::CommandsOpen& facts) const {
  if (!facts.insecure) return "commands: taken over DDS, from those whom its permissions name";
  return "commands: taken over DDS without security (insecure = true): everybody in its network may move the axes";
}

std::string EventSentence::operator()(const events::CommandAnswered& facts) const {
  const auto asked = facts.axis.empty() ? fmt::format("{}: {}", facts.who, facts.what)
                                        : fmt::format("{}: axis {}: {}", facts.who, facts.axis, facts.what);
  return facts.refusal.empty() ? asked : fmt::format("{}: refused: {}", asked, facts.refusal);
}

std::string EventSentence::operator()(const events::CommandsSummary& facts) const {
  return fmt::format("commands: more came than are told one by one: {} accepted, {} refused, {} not looked at",
                     facts.accepted, facts.refused, facts.dropped);
}

std::string EventSentence::operator()(const events::CommanderLost& facts) const {
  return fmt::format("{}: its bridge has stopped: its axes stop, and are free", facts.who);
}

std::string EventSentence::operator()(const events::InvalidCommands& /*facts*/) const {
  return "commands: what the bridge has written cannot be, and is left out";
}

}  // namespace driveline::runtime
