#pragma once

#include <optional>
#include <string>
#include <vector>

#include "support/delay_histogram.hpp"
#include "support/options.hpp"
#include "support/samples.hpp"

namespace driveline::bench {

/// A figure of the same run for comparison.
struct Baseline {
  std::string name;
  Summary figures;
  /// Ratios to this baseline, of each turn that both took: for the confidence interval. Empty: no turns.
  RatioTurns ratios{};
};

/// A figure over time, in windows of equal length.
struct Course {
  double window_s = 0.0;
  std::vector<double> p50{};
  std::vector<double> p99{};
  std::vector<double> max{};
};

/// A thread that ran on the processor while another one waited for it.
struct RanInstead {
  std::string thread;
  double us = 0.0;
};

/// A line of a report.
struct Row {
  std::string name;    ///< the case, e.g. "32_axes"
  std::string metric;  ///< the measured quantity
  std::string unit;
  Summary figures;
  std::optional<double> aim{};  ///< upper limit of the median
  std::optional<Baseline> against{};
  std::optional<double> aim_p999{};        ///< upper limit of 99.9 % of the measurements
  std::optional<DelayHistogram> delays{};  ///< all measurements, for a picture of their distribution
  std::optional<Course> course{};          ///< the measurements over time, for a picture
  std::vector<RanInstead> ran_instead{};   ///< during the worst measurement, in this order
};

/// The result of a program: a text table or a JSON document with the same schema for all programs.
class Report {
 public:
  explicit Report(std::string bench) : bench_(std::move(bench)) {}

  void add(Row row) { rows_.push_back(std::move(row)); }
  /// Adds a remark below the table; not part of the JSON document.
  void note(std::string text) { notes_.push_back(std::move(text)); }
  /// Prints the report on stdout.
  void print(const Options& options) const;

 private:
  [[nodiscard]] std::string to_json(const Options& options) const;
  [[nodiscard]] std::string to_table() const;

  std::string bench_;
  std::vector<Row> rows_;
  std::vector<std::string> notes_;
};

}  // namespace driveline::bench
