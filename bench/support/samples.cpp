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

namespace {

/// Student's t for 97.5 % of `values` values, at least two.
double students_t(std::size_t values) {
  // By degrees of freedom, from 1.
  static constexpr std::array kQuantiles{12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23,
                                         2.20,  2.18, 2.16, 2.14, 2.13, 2.12, 2.11, 2.10, 2.09, 2.09};
  if (values < 2) throw std::invalid_argument("an interval takes two values or more");
  return kQuantiles[std::min(values - 2, kQuantiles.size() - 1)];
}

}  // namespace

Interval mean_difference_95(const std::vector<double>& values, const std::vector<double>& others) {
  const double t = students_t(values.size());
  const auto n = static_cast<double>(values.size());
  double mean = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) mean += (values[i] - others.at(i)) / n;
  double squares = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double from_mean = values[i] - others[i] - mean;
    squares += from_mean * from_mean;
  }
  const double half = t * std::sqrt(squares / (n - 1.0) / n);
  return {mean, mean - half, mean + half};
}

Interval interval_95(const std::vector<double>& ratios) {
  RatioTurns turns;
  for (const double ratio : ratios) turns.add(ratio, 1.0);
  return turns.interval_95();
}

// Welford's method: updates mean and squares with each value.
void RatioTurns::add(double figure, double floor) {
  if (!(figure > 0.0 && floor > 0.0)) return;
  const double logarithm = std::log(figure / floor);
  ++turns_;
  const double before = logarithm - mean_;
  mean_ += before / static_cast<double>(turns_);
  squares_ += before * (logarithm - mean_);
}

Interval RatioTurns::interval_95() const {
  const double t = students_t(turns_);
  const auto n = static_cast<double>(turns_);
  const double half = t * std::sqrt(squares_ / (n - 1.0) / n);
  return {std::exp(mean_), std::exp(mean_ - half), std::exp(mean_ + half)};
}

double upper_95(const std::vector<double>& ratios) {
  return interval_95(ratios).high;
}

void TurnSamples::add_turn(const std::vector<double>& samples) {
  medians_.push_back(summarize(samples).p50);
  all_.insert(all_.end(), samples.begin(), samples.end());
}

RatioTurns ratios_by_turn(const std::vector<double>& medians, const std::vector<double>& floor) {
  RatioTurns turns;
  for (std::size_t i = 0; i < std::min(medians.size(), floor.size()); ++i) turns.add(medians[i], floor[i]);
  return turns;
}

Summary divided(const Summary& summary, double divisor) {
  return {summary.n, summary.p50 / divisor, summary.p99 / divisor, summary.p999 / divisor, summary.max / divisor};
}

}  // namespace driveline::bench
