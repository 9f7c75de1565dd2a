#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {
namespace {

std::string bridge_text(std::int32_t process) {
  return process == 0 ? "of the service" : fmt::format("process {}", process);
}

}  // namespace

std::string EventSentence::operator()(const events::TelemetryOff& facts) const {
  return fmt::format("telemetry: off: {}", facts.reason);
}

std::string EventSentence::operator()(const events::BridgeStill& facts) const {
  return fmt::format("telemetry: bridge does not respond ({}): no sign of life for {} s, its samples are lost",
                     bridge_text(facts.process), std::chrono::duration<double>(facts.silence).count());
}

std::string EventSentence::operator()(const events::BridgeStopped& facts) const {
  return fmt::format("telemetry: bridge stopped ({}{}{}), restart in {} s", facts.how, facts.reason.empty() ? "" : ": ",
                     facts.reason, std::chrono::duration<double>(facts.pause).count());
}

std::string EventSentence::operator()(const events::BridgeBack& facts) const {
  return fmt::format("telemetry: bridge runs again ({})", bridge_text(facts.process));
}

std::string EventSentence::operator()(const events::BridgeRemark& facts) const {
  return fmt::format("telemetry: {}", facts.text);
}

std::string EventSentence::operator()(const events::InvalidBridgeCounts& /*facts*/) const {
  return "telemetry: invalid counters from the bridge are ignored";
}

}  // namespace driveline::runtime
