#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::EoeUp& facts) const {
  auto text = fmt::format("EoE: {} is {} here", facts.interface, to_text(facts.network));
  for (const auto& host : facts.hosts) text += fmt::format(", {} is {}", host.name, to_text(host.ip));
  for (const auto& route : facts.routes) text += "\n  " + route;
  return text;
}

std::string EventSentence::operator()(const events::EoeAddressRefused& facts) const {
  return fmt::format("{} refused the address {} and cannot be reached over EoE: {}",
                     slave_text(facts.slave, facts.name), to_text(facts.ip), ecat_master::describe(facts.error));
}

std::string EventSentence::operator()(const events::GatewayUp& facts) const {
  return fmt::format("mailbox gateway at {}:{}, UDP and TCP{}", to_text(facts.address), facts.port,
                     facts.read_only ? ", read-only" : "");
}

std::string EventSentence::operator()(const events::GatewayWritten& facts) const {
  return fmt::format("mailbox gateway: {} writes {} of {}", facts.client, facts.what,
                     slave_text(facts.slave, facts.name));
}

std::string EventSentence::operator()(const events::GatewayWriteRefused& facts) const {
  return fmt::format(
      "mailbox gateway: {} may not write {} of {}: write_users or write_addresses in [gateway] permits it; further "
      "refusals are only counted",
      facts.client, facts.what, slave_text(facts.slave, facts.name));
}

}  // namespace driveline::runtime
