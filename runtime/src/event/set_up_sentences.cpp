// Sentences of bring-up and shutdown.
#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::InterfaceOpened& facts) const {
  auto text = fmt::format("{}: {}", facts.interface, facts.access_method);
  for (const auto& step : facts.steps_down) text += fmt::format("\n  {}", step);
  return text;
}

std::string EventSentence::operator()(const events::SlavesFound& facts) const {
  return facts.count == 1 ? std::string("1 slave found") : fmt::format("{} slaves found", facts.count);
}

std::string EventSentence::operator()(const events::SlaveUnusable& facts) const {
  return ecat_master::describe(facts.error);
}

std::string EventSentence::operator()(const events::AliasNotUnique& facts) const {
  return ecat_master::describe(facts.duplicate);
}

std::string EventSentence::operator()(const events::NoDescription& /*facts*/) const {
  return "no description: process data as the slaves have assigned them, outputs zero, no axes";
}

std::string EventSentence::operator()(const events::TakenOver& facts) const {
  return fmt::format("slave {} is in OP, but no other master has been heard for {} ms: the line is taken over",
                     facts.slave, facts.listened.count());
}

std::string EventSentence::operator()(const events::LineDiffers& facts) const {
  std::string text = "the line is not as described:";
  for (const auto& sentence : ecat_master::describe(facts.comparison, facts.planned, facts.found)) {
    text += "\n  " + sentence;
  }
  return text;
}

std::string EventSentence::operator()(const events::ClocksBeingSet& /*facts*/) const {
  return "clocks: measuring delays, setting offsets, learning speeds";
}

std::string EventSentence::operator()(const events::Configured& facts) const {
  return fmt::format("configured, all in SAFEOP; {} bytes of process data in {} frame(s) take {}", facts.bytes,
                     facts.frames, describe(facts.wire, facts.on_interface));
}

std::string EventSentence::operator()(const events::ScaleDiffers& facts) const {
  return fmt::format(
      "axis {}: increments_per_revolution is {:.10g}, and by 6092h, 6091h and 608Fh of its drive a turn of the motor "
      "is "
      "{:.10g}; the line description counts",
      facts.axis, facts.described, facts.reported_by_drive);
}

std::string EventSentence::operator()(const events::NoProcessData& /*facts*/) const {
  return "there are no process data: no slave has PDOs assigned by itself; `driveline pdos` shows what they have, "
         "[[slave.pdo]] of a line description names what is to be exchanged";
}

std::string EventSentence::operator()(const events::RealtimeSetUp& facts) const {
  std::string text;
  for (const auto& line : rt::to_lines(facts.report)) text += fmt::format("{}  {}", text.empty() ? "" : "\n", line);
  return text;
}

std::string EventSentence::operator()(const events::ClocksLocked& facts) const {
  return fmt::format("clocks: locked to slave {}, which runs {:+.1f} ppm against this machine", facts.reference,
                     facts.ppm);
}

std::string EventSentence::operator()(const events::StateReached& facts) const {
  return fmt::format("all in {}", wire::to_text(facts.state));
}

std::string EventSentence::operator()(const events::NoPath& facts) const {
  return facts.enabled ? "there is no [path]: the axes are enabled and hold the place where they stand"
                       : "there is no [path]: the axes stay disabled until they are asked for";
}

}  // namespace driveline::runtime
