#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::cli {

/// Reads the document that a program of bench/ has printed with --json. Error: the missing part of the schema.
[[nodiscard]] tl::expected<nlohmann::json, std::string> parse_bench_document(const std::string& text);

/// What a row is compared with: "1.04 (0.98) x floor; by 20 turns 1.02 to 1.06", the median and 99.9 % over those of
/// the floor, then the 95 % interval of the ratios of turns; empty without a floor.
[[nodiscard]] std::string comparison_text(const nlohmann::json& row);

/// The documents as Markdown: all that was aimed at, then one section and table per program.
[[nodiscard]] std::string bench_report(const std::vector<nlohmann::json>& documents);

/// A picture of some figures: a file of data and the gnuplot script that draws `name`.svg from it.
struct BenchFigure {
  std::string name;
  std::string data;    ///< content of `name`.dat
  std::string script;  ///< content of `name`.gp
};

/// The pictures that can be drawn of these documents; those whose program is not among them are left out.
[[nodiscard]] std::vector<BenchFigure> bench_figures(const std::vector<nlohmann::json>& documents);

}  // namespace driveline::cli
