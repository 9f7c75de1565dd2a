#pragma once

#include "text/bench_report.hpp"

namespace driveline::cli {

/// How the figures of `bench/soak` went on over time, a panel each: median, 99 % and maximum of every window. The time
/// ends with the data. `document` has been checked by parse_bench_document().
[[nodiscard]] BenchFigure soak_figure(const nlohmann::json& document);

/// Of `bench/scale`: the master's part by the number of axes, for each cycle time, and by the cycle time how many axes
/// the wire and this machine allow.
[[nodiscard]] BenchFigure scale_figure(const nlohmann::json& document);

/// Of `bench/roundtrip`: medians by the size of the frame, of every port and its bare loop.
[[nodiscard]] BenchFigure roundtrip_figure(const nlohmann::json& document);

}  // namespace driveline::cli
