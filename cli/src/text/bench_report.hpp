#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::cli {

/// Reads the document that a program of bench/ has printed with --json. Error: the missing part of the schema.
[[nodiscard]] tl::expected<nlohmann::json, std::string> parse_bench_document(const std::string& text);

/// The documents as Markdown: one section and table per program, what was aimed at and whether it was met.
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
