#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// Writes the histograms of a run as CSV: lower and upper bound in ns, then the counts of wake-up latency and cycle
/// cost.
[[nodiscard]] runtime::Result<void> write_jitter_csv(const ecat_master::CycleStatistics& statistics,
                                                     const std::filesystem::path& file);

/// Draws the files in `directory` (jitter.csv, and axes.csv unless `axes` is empty) with gnuplot: jitter.png,
/// positions.png, following_error.png. The gnuplot script stays beside them. Returns the pictures by the key they have
/// in the report. Axes are in their units, with `increments` on a second axis in those of the drive as well. Error: a
/// sentence (gnuplot is not there or failed).
[[nodiscard]] tl::expected<std::map<std::string, std::filesystem::path>, std::string> draw_plots(
    const std::filesystem::path& directory, const std::vector<runtime::AxisReport>& axes, bool increments = false);

/// Draws clocks.png from clocks.csv in `directory`: time in the first column, one column per slave behind it. Error: a
/// sentence.
[[nodiscard]] tl::expected<std::filesystem::path, std::string> draw_clocks(const std::filesystem::path& directory,
                                                                           const std::vector<std::string>& names);

}  // namespace driveline::cli
