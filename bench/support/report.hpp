#pragma once

#include <optional>
#include <string>
#include <vector>

#include "support/delay_histogram.hpp"
#include "support/options.hpp"
#include "support/samples.hpp"

namespace driveline::bench {

/// A figure of the same run that another one is compared with.
struct Baseline {
  std::string name;
  Summary figures;
  /// The one over this of each turn that both had: how sure their ratio is. Empty: no turns.
  RatioTurns ratios{};
};

/// How a figure went on, in windows of time that are equally long.
struct Course {
  double window_s = 0.0;
  std::vector<double> p50{};
  std::vector<double> p99{};
  std::vector<double> max{};
};

/// A thread that had the processor while another one waited for it.
struct RanInstead {
  std::string thread;
  double us = 0.0;
};

/// One line of a report.
struct Row {
  std::string name;    ///< the case, e.g. "32_axes"
  std::string metric;  ///< what was measured of it
  std::string unit;
  Summary figures;
  std::optional<double> aim{};  ///< the median shall not be above
  std::optional<Baseline> against{};
  std::optional<double> aim_p999{};        ///< nor 99.9 % of the measurements above this
  std::optional<DelayHistogram> delays{};  ///< all measurements, for a picture of their distribution
  std::optional<Course> course{};          ///< the same
  std::vector<RanInstead> ran_instead{};   ///< during the worst of the measurements, in this order
};

/// The answer of one program: a table for people or one JSON document, the same schema for all programs.
class Report {
 public:
  explicit Report(std::string bench) : bench_(std::move(bench)) {}

  void add(Row row) { rows_.push_back(std::move(row)); }
  /// A remark below the table; not part of the JSON document.
  void note(std::string text) { notes_.push_back(std::move(text)); }
  /// On stdout.
  void print(const Options& options) const;

 private:
  [[nodiscard]] std::string to_json(const Options& options) const;
  [[nodiscard]] std::string to_table() const;

  std::string bench_;
  std::vector<Row> rows_;
  std::vector<std::string> notes_;
};

}  // namespace driveline::bench
