#include "config/fault_config.hpp"

#include <cmath>

namespace driveline::runtime {

namespace {

constexpr double kMaxTimeMs = 86'400'000.0;

std::chrono::nanoseconds from_ms(double ms) {
  return std::chrono::nanoseconds{std::llround(ms * 1e6)};
}

}  // namespace

FaultPlan read_fault(TomlReader reader, const FaultPlaces& places) {
  FaultPlan plan;
  plan.at = from_ms(reader.number_or("at_ms", 0.0, 0.0, kMaxTimeMs));
  const auto row = find_fault_kind(reader.text("kind"));
  if (!row) reader.fail("kind", row.error().reason);
  FaultDraft draft(**row);
  for (const auto& parameter : slaves::kFaultParameters) {
    if (!reader.has(parameter.key)) continue;
    const auto done = draft.set(parameter, reader.scalar_text(parameter.key), places);
    if (!done) reader.fail(parameter.key, done.error().reason);
  }
  if (reader.has("for_ms")) draft.set_duration(from_ms(reader.number("for_ms", 0.001, kMaxTimeMs)));
  reader.finish();
  const auto fault = draft.finish(places);
  if (!fault) reader.fail("", fault.error().reason);
  plan.fault = *fault;
  return plan;
}

}  // namespace driveline::runtime
