#include "driveline/runtime/record/run_report.hpp"

#include <algorithm>
#include <utility>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

const Event* RunReport::failure() const noexcept {
  const auto found = std::find_if(events.begin(), events.end(),
                                  [](const Event& event) { return event.severity == Severity::kFailure; });
  return found == events.end() ? nullptr : &*found;
}

const Event& RunReport::note_failure(Error error) {
  return events.emplace_back(Event{events::FileNotWritten{std::move(error)}, Severity::kFailure, std::nullopt});
}

}  // namespace driveline::runtime
