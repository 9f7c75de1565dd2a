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
  return "no description: process data as assigned by the slaves, outputs zero, no axes";
}

std::string EventSentence::operator()(const events::TakenOver& facts) const {
  return fmt::format(
      "slave {} is in OP, but no frame of another master arrived for {} ms: this run takes over the line", facts.slave,
      facts.listened.count());
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
      "axis {}: increments_per_revolution is {:.10g}, and objects 6092h, 6091h and 608Fh of its drive give {:.10g} "
      "increments per turn of the motor; driveline uses the line description",
      facts.axis, facts.described, facts.reported_by_drive);
}

std::string EventSentence::operator()(const events::StartupNoted& facts) const {
  return ecat_master::describe(facts.note);
}

std::string EventSentence::operator()(const events::NoProcessData& /*facts*/) const {
  return "there are no process data: no slave has a default PDO assignment; `driveline pdos` lists the PDOs of the "
         "slaves, [[slave.pdo]] of a line description selects the PDOs to exchange";
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
  return fmt::format("all in {}", facts.state);
}

std::string EventSentence::operator()(const events::NoPath& facts) const {
  return facts.enabled ? "there is no [path]: the axes are enabled and hold their positions"
                       : "there is no [path]: the axes stay disabled until a request enables them";
}

}  // namespace driveline::runtime
