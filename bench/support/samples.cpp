#include "support/samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

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

Interval interval_95(const std::vector<double>& ratios) {
  // Student's t for 97.5 %, by degrees of freedom from 1.
  static constexpr std::array kQuantiles{12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23,
                                         2.20,  2.18, 2.16, 2.14, 2.13, 2.12, 2.11, 2.10, 2.09, 2.09};
  if (ratios.size() < 2) throw std::invalid_argument("an interval takes two ratios or more");
  const double n = static_cast<double>(ratios.size());
  double mean = 0.0;
  for (const double ratio : ratios) mean += std::log(ratio) / n;
  double variance = 0.0;
  for (const double ratio : ratios) variance += (std::log(ratio) - mean) * (std::log(ratio) - mean) / (n - 1.0);
  const double t = kQuantiles[std::min(ratios.size() - 2, kQuantiles.size() - 1)];
  const double half = t * std::sqrt(variance / n);
  return {std::exp(mean), std::exp(mean - half), std::exp(mean + half)};
}

double upper_95(const std::vector<double>& ratios) {
  return interval_95(ratios).high;
}

void TurnSamples::add_turn(const std::vector<double>& samples) {
  medians_.push_back(summarize(samples).p50);
  all_.insert(all_.end(), samples.begin(), samples.end());
}

std::vector<double> ratios_by_turn(const std::vector<double>& medians, const std::vector<double>& floor) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(medians.size(), floor.size()); ++i) {
    if (medians[i] > 0.0 && floor[i] > 0.0) ratios.push_back(medians[i] / floor[i]);
  }
  return ratios;
}

Summary divided(const Summary& summary, double divisor) {
  return {summary.n, summary.p50 / divisor, summary.p99 / divisor, summary.p999 / divisor, summary.max / divisor};
}

}  // namespace driveline::bench
