#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::cli {

/// The documents of the benchmarks as a self-contained HTML page: the table of aims, then a section with a table per
/// program, with embedded pictures. `pictures`: SVG by name, each shown in the section of the program whose name its
/// name starts with. Content of documents and pictures is only displayed, never executed. parse_bench_document() must
/// have checked the documents.
[[nodiscard]] std::string bench_html(const std::vector<nlohmann::json>& documents,
                                     const std::map<std::string, std::string>& pictures);

}  // namespace driveline::cli
