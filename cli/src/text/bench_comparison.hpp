#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::cli {

/// Two runs of the benchmarks, figure by figure, as far as both have it: {"differences": [{"fact", "first", "second"}],
/// "rows": [...], "only_first": [...], "only_second": [...]}. A row has "bench", "case", "metric", "unit", the medians
/// "first" and "second" and their "ratio" (second over first). Where both runs have compared it with the same floor by
/// turns, also "against", "ratio_against" (how the ratio to that floor has changed: what the machine does to both is
/// not in it), its 95 % interval "low" and "high", and "verdict": "more", "less", or "same" where the interval holds 1.
/// The documents have been checked by parse_bench_document().
[[nodiscard]] nlohmann::json compare_benches(const std::vector<nlohmann::json>& first,
                                             const std::vector<nlohmann::json>& second);

/// compare_benches() for people.
[[nodiscard]] std::string comparison_report(const nlohmann::json& comparison);

}  // namespace driveline::cli
