// Sentences of the results of a run.
#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string EventSentence::operator()(const events::NotInInit& facts) const {
  return fmt::format("while returning to INIT: {}", ecat_master::describe(facts.error));
}

std::string EventSentence::operator()(const events::ForbiddenCalls& facts) const {
  return fmt::format("task \"{}\" has called {} function{} of heap or locks in the cycle", facts.task, facts.calls,
                     facts.calls == 1 ? "" : "s");
}

std::string EventSentence::operator()(const events::ForeignTraffic& facts) const {
  return ecat_master::describe_traffic(facts.statistics);
}

std::string EventSentence::operator()(const events::FaultRecorded& facts) const {
  return fmt::format("the {} cycles around the fault are in {}{}", facts.cycles, facts.file.string(),
                     facts.last ? "; the cycles around further faults are not recorded" : "");
}

std::string EventSentence::operator()(const events::RecordingShortened& facts) const {
  return fmt::format(
      "axes.csv and its plots have the end of the run, {} rows from {:.3f} s on; the figures cover the whole run",
      facts.rows, facts.begin_s);
}

std::string EventSentence::operator()(const events::CaptureIncomplete& facts) const {
  return fmt::format("capture: {} frames are missing in {}", facts.dropped, facts.file.string());
}

std::string EventSentence::operator()(const events::FileNotWritten& facts) const {
  return describe(facts.error);
}

}  // namespace driveline::runtime
