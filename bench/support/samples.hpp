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

/// A mean with its 95 % interval.
struct Interval {
  double mean = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Of so many ratios (positive, at least two; std::invalid_argument): their geometric mean, by Student's t over their
/// logarithms.
[[nodiscard]] Interval interval_95(const std::vector<double>& ratios);

/// Upper end of that interval.
[[nodiscard]] double upper_95(const std::vector<double>& ratios);

/// The mean of the differences of pairs (two at least, as many of the one as of the other) with its 95 % interval.
[[nodiscard]] Interval mean_difference_95(const std::vector<double>& values, const std::vector<double>& others);

/// Ratios of turns, however many, in memory that does not grow.
class RatioTurns {
 public:
  /// The ratio of two figures of one turn; nothing where one of them is not above zero.
  void add(double figure, double floor);
  [[nodiscard]] std::size_t turns() const noexcept { return turns_; }
  /// As that of the free function; of two turns at least.
  [[nodiscard]] Interval interval_95() const;

 private:
  std::size_t turns_ = 0;
  double mean_ = 0.0;     ///< of the logarithms
  double squares_ = 0.0;  ///< of their distances from it
};

/// What was measured of one way in turns with others.
class TurnSamples {
 public:
  /// One turn; not empty.
  void add_turn(const std::vector<double>& samples);
  [[nodiscard]] const std::vector<double>& all() const noexcept { return all_; }
  /// Of each turn.
  [[nodiscard]] const std::vector<double>& medians() const noexcept { return medians_; }

 private:
  std::vector<double> all_;
  std::vector<double> medians_;
};

/// The median of each turn of the one over that of the other in the same turn; both have as many turns.
[[nodiscard]] RatioTurns ratios_by_turn(const std::vector<double>& medians, const std::vector<double>& floor);

/// The summary of the samples divided by `divisor` (> 0).
[[nodiscard]] Summary divided(const Summary& summary, double divisor);

}  // namespace driveline::bench
