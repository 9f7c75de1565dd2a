#pragma once

#include <fmt/format.h>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::bench {

/// Largest share of a processor that a simulated line may need in real time. With more it falls behind whenever the
/// machine is busy for a moment, and the sync manager watchdogs of its drives expire.
inline constexpr double kMaxSimulationLoad = 0.7;

/// Returns a note for the report if this machine is too slow to simulate the line of case `name` in real time, so the
/// case cannot be measured. `load`: processor time per elapsed time that the line needs, measured on virtual time.
[[nodiscard]] inline std::optional<std::string> beyond_real_time(std::string_view name, double load) {
  if (load <= kMaxSimulationLoad) return std::nullopt;
  return fmt::format("{}: not measured, its drives need {:.0f} % of a processor here (at most {:.0f} %)", name,
                     load * 100.0, kMaxSimulationLoad * 100.0);
}

}  // namespace driveline::bench
