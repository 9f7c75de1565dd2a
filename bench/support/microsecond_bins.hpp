#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

namespace driveline::bench {

/// A whole distribution of delays: how many there are in each microsecond. None is left out, however long.
struct MicrosecondBins {
  std::map<std::int64_t, std::uint64_t> counts;  ///< by the microsecond in which the delay lies, rounded down
  double deadline_us = 0.0;                      ///< a delay as long is a period that was missed

  /// Adds delays in ns.
  void add(const std::vector<double>& delays_ns);
  [[nodiscard]] std::uint64_t total() const;
  /// Delays of at least deadline_us.
  [[nodiscard]] std::uint64_t missed() const;
};

/// Appends the delay of an event and those of the instants that were missed before it, each by its own time: `late` is
/// from the first of `missed` + 1 instants. As rt::record_lateness(), but exact.
void add_delays(std::vector<double>& delays_ns, std::chrono::nanoseconds late, std::int64_t missed,
                std::chrono::nanoseconds period);

}  // namespace driveline::bench
