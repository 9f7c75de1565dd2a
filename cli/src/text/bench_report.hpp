#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::cli {

/// Parses the document that a program of bench/ prints with --json. Error: the missing part of the schema.
[[nodiscard]] tl::expected<nlohmann::json, std::string> parse_bench_document(const std::string& text);

/// The comparison of a row with its floor: "1.04 (0.98) x floor; by 20 turns 1.02 to 1.06": the ratios of the medians
/// and of the 99.9 % percentiles, then the 95 % interval of the ratios of turns; empty without a floor.
[[nodiscard]] std::string comparison_text(const nlohmann::json& row);

/// The documents as Markdown: the table of aims, then a section with a table per program.
[[nodiscard]] std::string bench_report(const std::vector<nlohmann::json>& documents);

/// A picture of some figures: a data file and the gnuplot script that draws `name`.svg from it.
struct BenchFigure {
  std::string name;
  std::string data;    ///< content of `name`.dat
  std::string script;  ///< content of `name`.gp
};

/// The pictures that can be drawn from these documents; pictures of missing programs are left out.
[[nodiscard]] std::vector<BenchFigure> bench_figures(const std::vector<nlohmann::json>& documents);

}  // namespace driveline::cli
