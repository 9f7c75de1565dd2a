#include "support/samples.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::bench {

Summary summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto at = [&samples](double share) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(samples.size())));
    return samples[std::clamp<std::size_t>(rank, 1, samples.size()) - 1];
  };
  return {samples.size(), at(0.5), at(0.99), at(0.999), samples.back()};
}

Summary divided(const Summary& summary, double divisor) {
  return {summary.n, summary.p50 / divisor, summary.p99 / divisor, summary.p999 / divisor, summary.max / divisor};
}

}  // namespace driveline::bench
