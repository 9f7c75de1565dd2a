#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::cli {

/// Compares two runs of the benchmarks, figure by figure, as far as both have them: {"differences": [{"fact", "first",
/// "second"}], "rows": [...], "only_first": [...], "only_second": [...]}. A row has "bench", "case", "metric", "unit",
/// the medians "first" and "second" and their "ratio" (second over first). If both runs have compared the figure by
/// turns with the same floor, it also has "against", "ratio_against" (the change of the ratio to that floor, without
/// what the machine does to both), its 95 % interval "low" and "high", and "verdict": "more", "less", or "same" if the
/// interval contains 1. parse_bench_document() must have checked the documents.
[[nodiscard]] nlohmann::json compare_benches(const std::vector<nlohmann::json>& first,
                                             const std::vector<nlohmann::json>& second);

/// The result of compare_benches() as text.
[[nodiscard]] std::string comparison_report(const nlohmann::json& comparison);

}  // namespace driveline::cli
