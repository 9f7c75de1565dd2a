#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::bench {

/// What cyclictest (rt-tests) is asked for: one thread, one histogram.
struct CyclictestJob {
  std::chrono::microseconds period{125};
  int cpu = 0;
  int priority = 80;
  int loops = 0;
};

/// Latencies in ns of a report of `cyclictest -q -h N`, in no order; it tells whole microseconds, rounded down. Those
/// beyond its histogram are known by number and largest only: all of them are taken for the largest. Throws
/// std::runtime_error for a text that is no such report, or is of another number of loops than `loops`.
[[nodiscard]] std::vector<double> parse_cyclictest(std::string_view text, int loops);

/// Runs it. None: it is not on this machine. Throws std::runtime_error when it fails.
[[nodiscard]] std::optional<std::vector<double>> run_cyclictest(const CyclictestJob& job);

}  // namespace driveline::bench
