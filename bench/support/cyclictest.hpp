#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::bench {

/// Parameters for cyclictest (rt-tests): one thread, one histogram.
struct CyclictestJob {
  std::chrono::microseconds period{125};
  int cpu = 0;
  int priority = 80;
  int loops = 0;
};

/// Parses a report of `cyclictest -q -h N`: latencies in ns, unordered, rounded down to whole microseconds. Of
/// latencies beyond the histogram only number and largest are known; all of them are set to the largest. Throws
/// std::runtime_error for a text that is not such a report, or has another number of loops than `loops`.
[[nodiscard]] std::vector<double> parse_cyclictest(std::string_view text, int loops);

/// Runs cyclictest. None: it is not installed. Throws std::runtime_error if it fails.
[[nodiscard]] std::optional<std::vector<double>> run_cyclictest(const CyclictestJob& job);

}  // namespace driveline::bench
