#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {

/// Something that happened, as a line across the pictures of the axes.
struct PlotMark {
  double time_s = 0.0;  ///< in operation
  bool missed = false;  ///< the master was away: periods without a cycle
  std::string text{};   ///< in a word or two
};

/// What the pictures show besides the files.
struct PlotFacts {
  std::chrono::nanoseconds period{};               ///< of the cycle; 0: the wake-up latency has no deadline
  std::array<std::chrono::nanoseconds, 4> wake{};  ///< latency: 50, 99 and 99.9 %, and the largest
  std::array<std::chrono::nanoseconds, 4> cost{};  ///< of a cycle, likewise
  std::vector<PlotMark> marks{};
};

/// The facts of a run: faults and what else happened while it was in operation are marks, at most 60 of them.
[[nodiscard]] PlotFacts plot_facts(const runtime::RunReport& report);

/// Writes the histograms of a run as CSV: lower and upper bound in ns, then the counts of wake-up latency and cycle
/// cost.
[[nodiscard]] runtime::Result<void> write_jitter_csv(const ecat_master::CycleStatistics& statistics,
                                                     const std::filesystem::path& file);

/// Draws the files in `directory` (jitter.csv, and axes.csv unless `axes` is empty) with gnuplot: jitter.png,
/// positions.png, following_error.png. The gnuplot script stays beside them. Axes are in their units, with `increments`
/// on a second axis in those of the drive as well. The bars of jitter.png are equally wide on a logarithmic axis and
/// hold every cycle: those below 25 ns, which the clock cannot tell apart, and wake-ups that came a period or more too
/// late have a bar of their own. Error: a sentence (gnuplot is not there or failed).
[[nodiscard]] tl::expected<Drawing, std::string> draw_plots(const std::filesystem::path& directory,
                                                            const std::vector<runtime::AxisReport>& axes,
                                                            bool increments = false, const PlotFacts& facts = {});

/// Draws clocks.png from clocks.csv in `directory`: time in the first column, one column per slave behind it. Error: a
/// sentence.
[[nodiscard]] tl::expected<Drawing, std::string> draw_clocks(const std::filesystem::path& directory,
                                                             const std::vector<std::string>& names);

}  // namespace driveline::cli
