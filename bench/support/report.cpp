#include "support/report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "support/environment.hpp"

namespace driveline::bench {
namespace {

/// Rounds to a tenth of a unit, the resolution of the figures.
double rounded(double value) {
  return std::round(value * 10.0) / 10.0;
}

double ratio(double value, double base) {
  return base > 0.0 ? std::round(value / base * 1e4) / 1e4 : 0.0;
}

std::string aim_text(const Row& row) {
  return fmt::format("p50<={:g}", *row.aim) + (row.aim_p999 ? fmt::format(" p999<={:g}", *row.aim_p999) : "");
}

bool is_met(const Row& row) {
  return row.figures.p50 <= *row.aim && (!row.aim_p999 || row.figures.p999 <= *row.aim_p999);
}

nlohmann::ordered_json to_json(const DelayHistogram& delays) {
  return {{"bin_us", 1},
          {"deadline_us", delays.deadline_us()},
          {"missed", delays.missed()},
          {"bins", delays.microseconds()},
          {"per_decade", DelayHistogram::kPerDecade},
          {"unresolved", {{"below_bin", DelayHistogram::resolved_from()}, {"count", delays.unresolved()}}},
          {"log_bins", delays.decades()}};
}

nlohmann::ordered_json to_json(const Course& course) {
  const auto all_rounded = [](std::vector<double> values) {
    for (double& value : values) value = rounded(value);
    return values;
  };
  return {{"window_s", course.window_s},
          {"p50", all_rounded(course.p50)},
          {"p99", all_rounded(course.p99)},
          {"max", all_rounded(course.max)}};
}

/// The 95 % interval of the ratio, for the table.
std::string interval_text(const RatioTurns& ratios) {
  const auto interval = ratios.interval_95();
  return fmt::format(" [{:.3g} to {:.3g} in {} turns]", interval.low, interval.high, ratios.turns());
}

/// The confidence interval of the ratio, from the turns.
nlohmann::ordered_json to_json(const RatioTurns& ratios) {
  const auto interval = ratios.interval_95();
  // Four significant digits: with few turns, the lower end is small, but never zero.
  const auto digits = [](double value) {
    const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(value)));
    return std::round(value * scale) / scale;
  };
  return {{"turns", ratios.turns()},
          {"mean", digits(interval.mean)},
          {"low", digits(interval.low)},
          {"high", digits(interval.high)}};
}

nlohmann::ordered_json to_json(const Row& row) {
  const auto& figures = row.figures;
  nlohmann::ordered_json json{{"case", row.name},
                              {"metric", row.metric},
                              {"unit", row.unit},
                              {"n", figures.n},
                              {"p50", rounded(figures.p50)},
                              {"p99", rounded(figures.p99)},
                              {"p999", rounded(figures.p999)},
                              {"max", rounded(figures.max)}};
  if (row.against) {
    json["against"] = row.against->name;
    json["ratio_p50"] = ratio(figures.p50, row.against->figures.p50);
    json["ratio_p999"] = ratio(figures.p999, row.against->figures.p999);
    if (row.against->ratios.turns() > 1) json["ratio_turns"] = bench::to_json(row.against->ratios);
  }
  if (row.aim) {
    json["aim"] = aim_text(row);
    json["met"] = is_met(row);
  }
  if (row.delays) json["histogram"] = bench::to_json(*row.delays);
  if (row.course) json["over_time"] = bench::to_json(*row.course);
  for (const auto& one : row.ran_instead) {
    json["ran_instead"].push_back({{"thread", one.thread}, {"us", rounded(one.us)}});
  }
  return json;
}

}  // namespace

std::string Report::to_json(const Options& options) const {
  auto where = environment_json();
  where["quick"] = options.quick;
  where["short"] = options.shorter;
  auto results = nlohmann::ordered_json::array();
  for (const auto& row : rows_) results.push_back(bench::to_json(row));
  const nlohmann::ordered_json document{{"bench", bench_}, {"environment", where}, {"results", results}};
  return document.dump(2) + "\n";
}

std::string Report::to_table() const {
  const auto where = environment();
  std::string text = fmt::format(
      "{}: kernel {}, {} ({} cores{}), {} ({}){}; others took {:.2f} processors, the host {:.2f}\n\n", bench_,
      where.kernel, where.cpu, where.cores, where.virtual_machine ? ", virtual machine" : "", where.compiler,
      where.build, where.commit.empty() ? "" : ", commit " + where.commit, where.other_load, where.stolen_load);
  std::size_t width = 4;
  for (const auto& row : rows_) width = std::max(width, row.name.size());
  text += fmt::format("{:<{}} {:<22} {:<8}{:>9}{:>12}{:>12}{:>12}{:>12}\n", "case", width, "metric", "unit", "n", "p50",
                      "p99", "p99.9", "max");
  for (const auto& row : rows_) {
    const auto& figures = row.figures;
    text += fmt::format("{:<{}} {:<22} {:<8}{:>9}{:>12.1f}{:>12.1f}{:>12.1f}{:>12.1f}", row.name, width, row.metric,
                        row.unit, figures.n, figures.p50, figures.p99, figures.p999, figures.max);
    if (row.aim) text += fmt::format("  aim {}: {}", aim_text(row), is_met(row) ? "met" : "MISSED");
    if (row.against) {
      const auto& base = row.against->figures;
      text += fmt::format("  {:.3g} x {}", ratio(figures.p50, base.p50), row.against->name);
      if (row.aim_p999) text += fmt::format(" (p99.9 {:.3g} x)", ratio(figures.p999, base.p999));
      if (row.against->ratios.turns() > 1) text += interval_text(row.against->ratios);
    }
    text += '\n';
  }
  for (const auto& note : notes_) text += "\n" + note + "\n";
  return text;
}

void Report::print(const Options& options) const {
  fmt::print("{}", options.json ? to_json(options) : to_table());
}

}  // namespace driveline::bench
