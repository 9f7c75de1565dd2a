#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "text/axis_plots.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {

/// Additional data for the pictures.
struct PlotFacts {
  std::chrono::nanoseconds period{};               ///< cycle time; 0: the wake-up latency has no deadline
  std::array<std::chrono::nanoseconds, 4> wake{};  ///< wake-up latency: 50, 99 and 99.9 %, and the largest
  std::array<std::chrono::nanoseconds, 4> cost{};  ///< cost of a cycle, likewise
  std::vector<PlotMark> marks{};
};

/// The data of a run: events of its operation from severity kNotice on become marks, at most the last 60, and
/// the longest absence of the master.
[[nodiscard]] PlotFacts plot_facts(const runtime::RunReport& report);

/// Writes the histograms of a run as CSV: lower and upper bound in ns, then the counts of wake-up latency and cycle
/// cost.
[[nodiscard]] runtime::Result<void> write_jitter_csv(const motion::CycleStatistics& statistics,
                                                     const std::filesystem::path& file);

/// Draws the files in `directory` (jitter.csv, and axes.csv unless `axes` is empty) with gnuplot: jitter.png,
/// positions.png, following_error.png. The gnuplot scripts remain beside them. Axes are in their units; with
/// `increments` a second axis is in drive increments. The bars of jitter.png have equal width on a logarithmic axis and
/// contain every cycle: times below 25 ns, the resolution of the clock, have a bar of their own, and wake-ups that were
/// a period or more too late are red. The pictures of the axes have one legend, numbers at the events, and the
/// sentences about them below. Error: a sentence (gnuplot is missing or failed).
[[nodiscard]] tl::expected<Drawing, std::string> draw_plots(const std::filesystem::path& directory,
                                                            const std::vector<runtime::AxisRunReport>& axes,
                                                            bool increments = false, const PlotFacts& facts = {});

/// Draws clocks.png from clocks.csv in `directory`: time in the first column, then one column per slave. Error: a
/// sentence.
[[nodiscard]] tl::expected<Drawing, std::string> draw_clocks(const std::filesystem::path& directory,
                                                             const std::vector<std::string>& names);

}  // namespace driveline::cli
