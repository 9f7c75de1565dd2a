#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::TelemetryOff& facts) const {
  return fmt::format("telemetry: off: {}", facts.reason);
}

std::string EventSentence::operator()(const events::BridgeStopped& facts) const {
  return fmt::format("telemetry: bridge stopped ({}{}{}), restart in {} s", facts.how, facts.reason.empty() ? "" : ": ",
                     facts.reason, std::chrono::duration<double>(facts.pause).count());
}

std::string EventSentence::operator()(const events::BridgeBack& facts) const {
  return fmt::format("telemetry: bridge runs again (process {})", facts.process);
}

std::string EventSentence::operator()(const events::BridgeRemark& facts) const {
  return fmt::format("telemetry: {}", facts.text);
}

std::string EventSentence::operator()(const events::InvalidBridgeCounts& /*facts*/) const {
  return "telemetry: invalid counters from the bridge are ignored";
}

}  // namespace driveline::runtime
