#pragma once

#include <cstdint>

namespace driveline::runtime {

/// What became of the telemetry of a run, which `driveline-bridge` publishes.
struct TelemetryReport {
  std::uint64_t published = 0;  ///< axis samples handed to DDS, as the bridge counts them
  std::uint64_t dropped = 0;    ///< samples lost on the way there: no room in a ring, not taken in time, refused by DDS
  std::uint64_t restarts = 0;   ///< of the bridge
  std::uint64_t unbelieved = 0;  ///< looks at counts of the bridge that cannot be
};

}  // namespace driveline::runtime
