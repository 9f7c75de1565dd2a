// Sentences of events of the line in operation.
#include <fmt/format.h>

#include "driveline/motion/cia402/error_code.hpp"
#include "event/event_sentence.hpp"

namespace driveline::runtime {

using Milliseconds = std::chrono::duration<double, std::milli>;

std::string slave_text(std::size_t slave, const std::string& name) {
  return fmt::format("slave {} ({})", slave, name);
}

std::string cause_text(const std::optional<motion::MasterAbsence>& absence) {
  if (!absence) return {};
  return fmt::format("; the master had been away for {:.1f} ms at {:.3f} s", Milliseconds(absence->duration).count(),
                     std::chrono::duration<double>(absence->since).count());
}

std::string EventSentence::operator()(const events::Progress& facts) const {
  const auto seconds = std::chrono::duration<double>(event_.time.value_or(std::chrono::nanoseconds{0})).count();
  return fmt::format("{:6.1f} s  {}", seconds, facts.phase ? motion::to_text(*facts.phase) : "exchanging");
}

std::string EventSentence::operator()(const events::StopRequested& /*facts*/) const {
  return "stop requested: taking the line down";
}

std::string EventSentence::operator()(const events::SlaveNotConnected& facts) const {
  return fmt::format("{}: is not connected; it joins the line when it is connected",
                     slave_text(facts.slave, facts.name));
}

std::string EventSentence::operator()(const events::LineChanged& facts) const {
  return ecat_master::what_happened(facts.event, facts.slave) + cause_text(facts.after);
}

std::string EventSentence::operator()(const events::SlaveNotBack& facts) const {
  const auto slave = slave_text(facts.slave, facts.name);
  if (!facts.waited) return fmt::format("{}: was not back when the run ended", slave);
  return fmt::format("{}: not back within {} s", slave, facts.waited->count());
}

std::string EventSentence::operator()(const events::Emergency& facts) const {
  const auto& message = facts.record.message;
  return fmt::format("{}: emergency {}, error register 0x{:02X}", slave_text(facts.record.slave, facts.name),
                     motion::cia402::error_text(message.error_code), message.error_register);
}

std::string EventSentence::operator()(const events::SoeMessage& facts) const {
  return fmt::format("{}: {}", slave_text(facts.record.slave, facts.name), ecat_master::describe_message(facts.record));
}

std::string EventSentence::operator()(const events::CommunicationLost& facts) const {
  if (facts.late == 0) {
    return fmt::format("communication lost: no frame came back for {} cycles{}{}", facts.cycles,
                       facts.link.empty() ? "" : "; ", facts.link);
  }
  return fmt::format(
      "communication lost: frames return too late: none in time for {} cycles, {} after the end of their cycle",
      facts.cycles, facts.late);
}

std::string EventSentence::operator()(const events::CommunicationBack& /*facts*/) const {
  return "frames return again";
}

std::string EventSentence::operator()(const events::CommunicationNotBack& facts) const {
  return fmt::format("no frame came back within {} s", facts.waited.count());
}

std::string EventSentence::operator()(const events::BusFailed& facts) const {
  return ecat_master::describe(facts.error);
}

std::string EventSentence::operator()(const events::ClocksChanged& facts) const {
  // The sentence of a fault already names its subject.
  return (event_.is_fault() ? "" : "clocks: ") + ecat_master::dc::describe(facts.event);
}

std::string EventSentence::operator()(const events::ExchangeGroupZeroed& facts) const {
  return fmt::format("group {}: outputs zeroed after {} incomplete exchanges in a row", facts.group, facts.limit);
}

std::string EventSentence::operator()(const events::ExchangeGroupReleased& facts) const {
  return fmt::format("group {}: exchange complete again, outputs released", facts.group);
}

std::string EventSentence::operator()(const events::MasterAway& facts) const {
  return motion::describe(facts.absence, {}, max_lost_text(facts.limit));
}

std::string EventSentence::operator()(const events::MasterAwayOften& facts) const {
  return fmt::format("the master was away {} more times, {:.1f} ms in all, {:.1f} ms at the longest", facts.count,
                     Milliseconds(facts.total).count(), Milliseconds(facts.longest).count());
}

}  // namespace driveline::runtime
