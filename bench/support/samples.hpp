#pragma once

#include <cstddef>
#include <vector>

namespace driveline::bench {

/// Summary of a series of measurements. Percentiles by nearest rank: the value that this share of all values does not
/// exceed.
struct Summary {
  std::size_t n = 0;
  double p50 = 0.0;
  double p99 = 0.0;
  double p999 = 0.0;
  double max = 0.0;
};

/// All zero for no samples.
[[nodiscard]] Summary summarize(std::vector<double> samples);

/// Upper end of the 95 % interval of the mean of the logarithms of so many ratios (positive, at least two), as a ratio.
[[nodiscard]] double upper_95(const std::vector<double>& ratios);

/// The summary of the samples divided by `divisor` (> 0).
[[nodiscard]] Summary divided(const Summary& summary, double divisor);

}  // namespace driveline::bench
