#include "support/microsecond_bins.hpp"

#include <cmath>

namespace driveline::bench {

void MicrosecondBins::add(const std::vector<double>& delays_ns) {
  for (const double delay : delays_ns) ++counts[static_cast<std::int64_t>(std::floor(delay / 1000.0))];
}

std::uint64_t MicrosecondBins::total() const {
  std::uint64_t sum = 0;
  for (const auto& [us, count] : counts) sum += count;
  return sum;
}

std::uint64_t MicrosecondBins::missed() const {
  std::uint64_t sum = 0;
  for (const auto& [us, count] : counts) {
    if (static_cast<double>(us) >= deadline_us) sum += count;
  }
  return sum;
}

void add_delays(std::vector<double>& delays_ns, std::chrono::nanoseconds late, std::int64_t missed,
                std::chrono::nanoseconds period) {
  for (auto before = std::int64_t{0}; before <= missed; ++before) {
    delays_ns.push_back(std::abs(static_cast<double>((late - before * period).count())));
  }
}

}  // namespace driveline::bench
