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

/// All zero if there are no samples.
[[nodiscard]] Summary summarize(std::vector<double> samples);

/// A mean with its 95 % interval.
struct Interval {
  double mean = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Geometric mean of ratios (positive, at least two; std::invalid_argument), with its interval by Student's t on their
/// logarithms.
[[nodiscard]] Interval interval_95(const std::vector<double>& ratios);

/// Upper end of the interval of interval_95().
[[nodiscard]] double upper_95(const std::vector<double>& ratios);

/// The mean of the differences of pairs (at least two, with equal sizes) with its 95 % interval.
[[nodiscard]] Interval mean_difference_95(const std::vector<double>& values, const std::vector<double>& others);

/// Ratios of any number of turns, in constant memory.
class RatioTurns {
 public:
  /// Adds the ratio of two figures of a turn; ignored unless both are positive.
  void add(double figure, double floor);
  [[nodiscard]] std::size_t turns() const noexcept { return turns_; }
  /// Like the free function; needs at least two turns.
  [[nodiscard]] Interval interval_95() const;

 private:
  std::size_t turns_ = 0;
  double mean_ = 0.0;     ///< mean of the logarithms
  double squares_ = 0.0;  ///< sum of their squared distances from the mean
};

/// The measurements of a method that takes turns with others.
class TurnSamples {
 public:
  /// Adds the samples of a turn; not empty.
  void add_turn(const std::vector<double>& samples);
  [[nodiscard]] const std::vector<double>& all() const noexcept { return all_; }
  /// The median of each turn.
  [[nodiscard]] const std::vector<double>& medians() const noexcept { return medians_; }

 private:
  std::vector<double> all_;
  std::vector<double> medians_;
};

/// The medians of each turn over the floor's medians of the same turn; both have the same number of turns.
[[nodiscard]] RatioTurns ratios_by_turn(const std::vector<double>& medians, const std::vector<double>& floor);

/// The summary of the samples divided by `divisor` (> 0).
[[nodiscard]] Summary divided(const Summary& summary, double divisor);

}  // namespace driveline::bench
