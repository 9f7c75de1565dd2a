// Sentences of commands over DDS.
#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::CommandsOpen& facts) const {
  if (!facts.insecure) return "commands: accepted over DDS from the participants that the permissions allow";
  return "commands: accepted over DDS without security (insecure = true): any participant in the network may move the "
         "axes";
}

std::string EventSentence::operator()(const events::CommandAnswered& facts) const {
  const auto asked = facts.axis.empty() ? fmt::format("{}: {}", facts.who, facts.what)
                                        : fmt::format("{}: axis {}: {}", facts.who, facts.axis, facts.what);
  return facts.refusal.empty() ? asked : fmt::format("{}: refused: {}", asked, facts.refusal);
}

std::string EventSentence::operator()(const events::CommandsSummary& facts) const {
  return fmt::format("commands: too many to report one by one: {} accepted, {} refused, {} dropped unread",
                     facts.accepted, facts.refused, facts.dropped);
}

std::string EventSentence::operator()(const events::CommanderLost& facts) const {
  return fmt::format("{}: the bridge has stopped: the axes of this client stop, and their leases end", facts.who);
}

std::string EventSentence::operator()(const events::InvalidCommands& /*facts*/) const {
  return "commands: invalid data from the bridge is ignored";
}

}  // namespace driveline::runtime
