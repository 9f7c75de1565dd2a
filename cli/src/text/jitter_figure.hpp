#pragma once

#include <vector>

#include "text/bench_report.hpp"

namespace driveline::cli {

/// The distributions of `bench/jitter`: one picture per state of the machine and metric, a panel for each way of
/// waiting. Bins of a microsecond, logarithmic counts; every delay is in it, those of a period and more in a bar of
/// their own. Then the same with bars that are equally wide on a logarithmic axis, where the document has them, and one
/// for what is shorter than the clock can tell. `document` has been checked by parse_bench_document().
[[nodiscard]] std::vector<BenchFigure> jitter_figures(const nlohmann::json& document);

}  // namespace driveline::cli
