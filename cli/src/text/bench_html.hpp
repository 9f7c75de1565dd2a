#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::cli {

/// The documents of the benchmarks as one HTML page that needs no other file: all that was aimed at, then a section
/// and a table per program, with the pictures inside. `pictures`: SVG by name, each in the section of the program whose
/// name it begins with. What documents and pictures say is shown, never run. The documents have been checked by
/// parse_bench_document().
[[nodiscard]] std::string bench_html(const std::vector<nlohmann::json>& documents,
                                     const std::map<std::string, std::string>& pictures);

}  // namespace driveline::cli
