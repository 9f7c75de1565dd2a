// Sentences of events of a CAN line.
#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {
namespace {

std::string_view state_of_bus(canopen::BusState state) {
  using canopen::BusState;
  switch (state) {
    case BusState::kErrorActive:
      return "error active";
    case BusState::kErrorWarning:
      return "error active, with a warning";
    case BusState::kErrorPassive:
      return "error passive";
    case BusState::kBusOff:
      return "bus off";
    case BusState::kUnknown:
      break;
  }
  return "not known";
}

}  // namespace

std::string EventSentence::operator()(const events::CanPortOpened& facts) const {
  return fmt::format("{} at {:g} kbit/s, the master is node {}", facts.bus, facts.bit_rate / 1000.0, facts.master);
}

std::string EventSentence::operator()(const events::NodesConfigured& facts) const {
  return fmt::format("{} nodes configured, all in Pre-operational; {}", facts.nodes, describe(facts.budget));
}

std::string EventSentence::operator()(const events::NodeNoted& facts) const {
  return canopen::describe(facts.error, facts.name);
}

std::string EventSentence::operator()(const events::NodeChanged& facts) const {
  return canopen::describe(facts.event, facts.name) + cause_text(facts.after);
}

std::string EventSentence::operator()(const events::CanStateChanged& facts) const {
  auto text = fmt::format("the adapter is {}", state_of_bus(facts.state));
  if (facts.send_errors && facts.receive_errors) {
    text += fmt::format("; error counters: {} of sending, {} of receiving", *facts.send_errors, *facts.receive_errors);
  }
  return text;
}

std::string EventSentence::operator()(const events::NodeNotReleased& facts) const {
  return fmt::format("not in Pre-operational at the end: {}", canopen::describe(facts.error, facts.name));
}

}  // namespace driveline::runtime
