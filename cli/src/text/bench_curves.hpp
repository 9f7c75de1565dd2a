#pragma once

#include "text/bench_report.hpp"

namespace driveline::cli {

/// The figures of `bench/soak` over time, one panel each: median, 99 % and maximum of every window. The time axis ends
/// with the data. parse_bench_document() must have checked `document`.
[[nodiscard]] BenchFigure soak_figure(const nlohmann::json& document);

/// The figures of `bench/scale`: cost of the master over the number of axes, for each cycle time, and over the cycle
/// time the number of axes that the wire and this machine allow.
[[nodiscard]] BenchFigure scale_figure(const nlohmann::json& document);

/// The figures of `bench/roundtrip`: medians over the size of the frame, for every port and its bare loop.
[[nodiscard]] BenchFigure roundtrip_figure(const nlohmann::json& document);

}  // namespace driveline::cli
