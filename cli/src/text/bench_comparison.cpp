#include "text/bench_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <tuple>

namespace driveline::cli {
namespace {

using nlohmann::json;

/// Facts of the machine and the build that influence the figures.
constexpr std::string_view kComparedFacts[] = {
    "cpu",      "cores",      "virtual_machine", "kernel", "kernel_build", "kernel_options", "isolated_cpus",
    "governor", "interfaces", "compiler",        "build",  "commit",       "quick",          "short"};

using RowKey = std::tuple<std::string, std::string, std::string>;  ///< program, case, metric

std::map<RowKey, const json*> rows_of(const std::vector<json>& documents) {
  std::map<RowKey, const json*> rows;
  for (const auto& document : documents) {
    for (const auto& row : document["results"]) {
      rows[{document["bench"].get<std::string>(), row["case"].get<std::string>(), row["metric"].get<std::string>()}] =
          &row;
    }
  }
  return rows;
}

/// Facts that differ between documents of the same program, each difference once.
json differences_of(const std::vector<json>& first, const std::vector<json>& second) {
  auto differences = json::array();
  for (const auto fact : kComparedFacts) {
    for (const auto& before : first) {
      for (const auto& after : second) {
        if (before["bench"] != after["bench"]) continue;
        const auto was = before["environment"].value(std::string(fact), json{});
        const auto is = after["environment"].value(std::string(fact), json{});
        const json difference{{"fact", fact}, {"first", was}, {"second", is}};
        const bool told = std::find(differences.begin(), differences.end(), difference) != differences.end();
        if (was != is && !told) differences.push_back(difference);
      }
    }
  }
  return differences;
}

/// A ratio measured by turns: its logarithm, and half of its 95 % interval on the logarithmic scale.
struct LogRatio {
  double mean = 0.0;
  double half = 0.0;
};

std::optional<LogRatio> log_ratio(const json& row) {
  if (!row.contains("against") || !row.contains("ratio_turns")) return std::nullopt;
  const auto& turns = row["ratio_turns"];
  const double low = turns["low"].get<double>();
  const double high = turns["high"].get<double>();
  const double mean = turns["mean"].get<double>();
  if (!(low > 0.0 && mean > 0.0 && high >= low)) return std::nullopt;
  return LogRatio{std::log(mean), (std::log(high) - std::log(low)) / 2.0};
}

double four_digits(double value) {
  return std::round(value * 1e4) / 1e4;
}

/// The runs are independent, so the squares of their uncertainties add up.
void add_interval(json& row, const json& before, const json& after) {
  const auto was = log_ratio(before);
  const auto is = log_ratio(after);
  if (!was || !is || before["against"] != after["against"]) return;
  const double mean = is->mean - was->mean;
  const double half = std::hypot(was->half, is->half);
  row["against"] = after["against"];
  row["ratio_against"] = four_digits(std::exp(mean));
  row["low"] = four_digits(std::exp(mean - half));
  row["high"] = four_digits(std::exp(mean + half));
  row["verdict"] = mean - half > 0.0 ? "more" : mean + half < 0.0 ? "less" : "same";
}

json names_only_in(const std::map<RowKey, const json*>& rows, const std::map<RowKey, const json*>& others) {
  auto names = json::array();
  for (const auto& [key, row] : rows) {
    if (!others.contains(key))
      names.push_back(fmt::format("{} {} {}", std::get<0>(key), std::get<1>(key), std::get<2>(key)));
  }
  return names;
}

std::string shown(const json& value) {
  return value.is_null() ? "unknown" : value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

json compare_benches(const std::vector<json>& first, const std::vector<json>& second) {
  const auto before = rows_of(first);
  const auto after = rows_of(second);
  auto rows = json::array();
  for (const auto& [key, row] : before) {
    const auto found = after.find(key);
    if (found == after.end() || (*row)["unit"] != (*found->second)["unit"]) continue;
    const auto was = (*row)["p50"].get<double>();
    const auto is = (*found->second)["p50"].get<double>();
    json compared{{"bench", std::get<0>(key)},
                  {"case", std::get<1>(key)},
                  {"metric", std::get<2>(key)},
                  {"unit", (*row)["unit"]},
                  {"first", was},
                  {"second", is},
                  {"ratio", nullptr}};
    if (was > 0.0) compared["ratio"] = four_digits(is / was);
    add_interval(compared, *row, *found->second);
    rows.push_back(std::move(compared));
  }
  return {{"differences", differences_of(first, second)},
          {"rows", std::move(rows)},
          {"only_first", names_only_in(before, after)},
          {"only_second", names_only_in(after, before)}};
}

std::string comparison_report(const json& comparison) {
  std::string text;
  for (const auto& difference : comparison["differences"]) {
    text += fmt::format("{}: {}, then {}\n", difference["fact"].get<std::string>(), shown(difference["first"]),
                        shown(difference["second"]));
  }
  if (!text.empty()) text += "\n";
  text += fmt::format("{:<12} {:<36} {:<42} {:>12} {:>12} {:<6} {:>7}  {}\n", "program", "case", "metric", "first",
                      "second", "unit", "ratio", "relative to its floor, 95 % interval over rounds");
  for (const auto& row : comparison["rows"]) {
    text += fmt::format("{:<12} {:<36} {:<42} {:>12.1f} {:>12.1f} {:<6} {:>7}", row["bench"].get<std::string>(),
                        row["case"].get<std::string>(), row["metric"].get<std::string>(), row["first"].get<double>(),
                        row["second"].get<double>(), row["unit"].get<std::string>(),
                        row["ratio"].is_null() ? "" : fmt::format("{:.3f}", row["ratio"].get<double>()));
    if (row.contains("verdict")) {
      text += fmt::format("  {:.3f} ({:.3f} to {:.3f}) {} x {}", row["ratio_against"].get<double>(),
                          row["low"].get<double>(), row["high"].get<double>(), row["verdict"].get<std::string>(),
                          row["against"].get<std::string>());
    }
    text += "\n";
  }
  for (const auto& [key, title] : {std::pair{"only_first", "first"}, std::pair{"only_second", "second"}}) {
    const auto& names = comparison[key];
    if (!names.empty()) text += fmt::format("\nFigures that only the {} run has: {}\n", title, names.size());
  }
  return text;
}

}  // namespace driveline::cli
