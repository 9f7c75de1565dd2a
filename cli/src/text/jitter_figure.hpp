#pragma once

#include <vector>

#include "text/bench_report.hpp"

namespace driveline::cli {

/// The distributions of `bench/jitter`: a picture per state of the machine and metric, with a panel for each method of
/// waiting. Bins of a microsecond, logarithmic counts; every delay is shown, delays of a period and more in a bar of
/// their own. Then, if the document has them, the same in bars of equal width on a logarithmic axis, where missed
/// periods are at their delays, with one more bar for delays below the resolution of the clock. parse_bench_document()
/// must have checked `document`.
[[nodiscard]] std::vector<BenchFigure> jitter_figures(const nlohmann::json& document);

}  // namespace driveline::cli
