#pragma once

#include <cstdint>

namespace driveline::runtime {

/// Figures of the telemetry of a run, which `driveline-bridge` publishes.
struct TelemetryReport {
  std::uint64_t published = 0;       ///< axis samples passed to DDS, as counted by the bridge
  std::uint64_t dropped = 0;         ///< samples lost: no room in a ring, not taken in time, refused by DDS
  std::uint64_t restarts = 0;        ///< restarts of the bridge
  std::uint64_t invalid_counts = 0;  ///< checks that found impossible counts of the bridge
};

}  // namespace driveline::runtime
