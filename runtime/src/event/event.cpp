#include "driveline/runtime/event.hpp"

#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

std::string describe(const Event& event, bool increments) {
  return std::visit(EventSentence(event, increments), event.facts);
}

std::string describe_with_time(const Event& event, bool increments) {
  auto sentence = describe(event, increments);
  if (!event.time) return sentence;
  return fmt::format("{:.3f} s {}", std::chrono::duration<double>(*event.time).count(), sentence);
}

}  // namespace driveline::runtime
