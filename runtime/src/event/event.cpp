#include "driveline/runtime/event.hpp"

#include <fmt/format.h>

#include "event/event_sentence.hpp"

namespace driveline::runtime {

namespace {

template <typename... Kinds>
std::string sentence_of(const EventFacts& facts, const EventSentence& make, EventKindList<Kinds...>) {
  std::string sentence;
  static_cast<void>(((facts.is<Kinds>() && (sentence = make(*facts.as<Kinds>()), true)) || ...));
  return sentence;
}

}  // namespace

std::string describe(const Event& event, bool increments) {
  return sentence_of(event.facts, EventSentence(event, increments), EventKinds{});
}

std::string describe_with_time(const Event& event, bool increments) {
  auto sentence = describe(event, increments);
  if (!event.time) return sentence;
  return fmt::format("{:.3f} s {}", std::chrono::duration<double>(*event.time).count(), sentence);
}

}  // namespace driveline::runtime
