#include "text/bench_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "text/bench_curves.hpp"
#include "text/jitter_figure.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

constexpr std::string_view kSvgTerminal =
    "set terminal svg size 860,360 font 'sans,11' background 'white' noenhanced\n";

/// Keys that every row of a document must have; the others are optional.
constexpr std::string_view kResultKeys[] = {"case", "metric", "unit"};
constexpr std::string_view kFigures[] = {"n", "p50", "p99", "p999", "max"};

bool is_bin(const json& bin) {
  return bin.is_array() && bin.size() == 2 && bin[0].is_number_integer() && bin[1].is_number_unsigned();
}

/// Checks that a distribution is complete: the counts of its microsecond bins add up to all measurements, and those
/// from the deadline on to the missed ones.
std::optional<std::string> histogram_problem(const json& row) {
  if (!row.contains("histogram")) return std::nullopt;
  const auto& histogram = row["histogram"];
  const auto has = [&histogram](const char* key, auto is) { return histogram.contains(key) && is(histogram[key]); };
  if (!histogram.is_object() || !has("deadline_us", [](const json& value) { return value.is_number(); }) ||
      !has("missed", [](const json& value) { return value.is_number_unsigned(); }) ||
      !has("bins", [](const json& value) { return value.is_array(); }))
    return "a histogram lacks \"deadline_us\", \"missed\" or \"bins\"";
  std::uint64_t total = 0;
  std::uint64_t missed = 0;
  for (const auto& bin : histogram["bins"]) {
    if (!is_bin(bin)) return "a bin of a histogram is not [microsecond, count]";
    const auto count = bin[1].get<std::uint64_t>();
    total += count;
    if (bin[0].get<double>() >= histogram["deadline_us"].get<double>()) missed += count;
  }
  if (total != row["n"].get<std::uint64_t>())
    return fmt::format("a histogram holds {} measurements of {}", total, row["n"].dump());
  if (missed != histogram["missed"].get<std::uint64_t>())
    return fmt::format("a histogram reports {} missed measurements, but has {}", histogram["missed"].dump(), missed);
  return std::nullopt;
}

/// Checks that the logarithmic bins contain all measurements, too.
std::optional<std::string> log_bins_problem(const json& row) {
  if (!row.contains("histogram") || !row["histogram"].contains("log_bins")) return std::nullopt;
  const auto& histogram = row["histogram"];
  const auto& unresolved = histogram.value("unresolved", json{});
  if (!histogram.contains("per_decade") || !histogram["per_decade"].is_number_unsigned() || !unresolved.is_object() ||
      !unresolved.contains("below_bin") || !unresolved["below_bin"].is_number_integer() ||
      !unresolved.contains("count") || !unresolved["count"].is_number_unsigned() || !histogram["log_bins"].is_array())
    return "logarithmic bins lack \"per_decade\" or \"unresolved\"";
  auto total = unresolved["count"].get<std::uint64_t>();
  for (const auto& bin : histogram["log_bins"]) {
    if (!is_bin(bin)) return "a logarithmic bin is not [number, count]";
    total += bin[1].get<std::uint64_t>();
  }
  if (total == row["n"].get<std::uint64_t>()) return std::nullopt;
  return fmt::format("logarithmic bins hold {} measurements of {}", total, row["n"].dump());
}

/// Checks the ratio measured by turns, and the figures over time.
std::optional<std::string> detail_problem(const json& row) {
  if (row.contains("ratio_turns")) {
    for (const auto* key : {"turns", "mean", "low", "high"}) {
      if (!row["ratio_turns"].is_object() || !row["ratio_turns"].contains(key) || !row["ratio_turns"][key].is_number())
        return fmt::format("the ratio of a result by turns has no \"{}\"", key);
    }
    if (row["ratio_turns"]["low"].get<double>() <= 0.0) return "the ratio of a result by turns is not above zero";
  }
  if (!row.contains("over_time")) return std::nullopt;
  const auto& course = row["over_time"];
  if (!course.is_object() || !course.contains("window_s") || !course["window_s"].is_number())
    return "a course over time has no \"window_s\"";
  for (const auto* key : {"p50", "p99", "max"}) {
    if (!course.contains(key) || !course[key].is_array() || course[key].size() != course.value("p50", json{}).size() ||
        !std::all_of(course[key].begin(), course[key].end(), [](const json& value) { return value.is_number(); }))
      return fmt::format("a course over time has no \"{}\" of each window", key);
  }
  return std::nullopt;
}

/// A table of all rows with an aim, and their measured values; empty: no row has an aim.
std::string aims_text(const std::vector<json>& documents) {
  std::string text;
  for (const auto& document : documents) {
    for (const auto& row : document["results"]) {
      if (!row.contains("aim")) continue;
      text += fmt::format("| {} | {} | {} | {:.1f} {} | {} | {} |\n", document["bench"].get<std::string>(),
                          row["case"].get<std::string>(), row["metric"].get<std::string>(), row["p50"].get<double>(),
                          row["unit"].get<std::string>(), row["aim"].get<std::string>(),
                          row.value("met", false) ? "met" : "**missed**");
    }
  }
  if (text.empty()) return text;
  return "\n## Targets\n\n| program | case | metric | p50 | aim | |\n|---|---|---|---:|---|---|\n" + text;
}

std::string row_text(const json& row) {
  auto text = fmt::format("| {} | {} | {} |", row["case"].get<std::string>(), row["metric"].get<std::string>(),
                          row["unit"].get<std::string>());
  for (const auto* key : {"p50", "p99", "p999", "max"}) text += fmt::format(" {:.1f} |", row[key].get<double>());
  text += row.contains("aim")
              ? fmt::format(" {}: {} |", row["aim"].get<std::string>(), row.value("met", false) ? "met" : "**missed**")
              : std::string(" |");
  const auto comparison = comparison_text(row);
  return text + (comparison.empty() ? " |\n" : fmt::format(" {} |\n", comparison));
}

/// The number in front of `tail` at the end of a name: 32 in "paced_32_axes".
std::optional<int> number_before(std::string_view name, std::string_view tail) {
  if (!name.ends_with(tail)) return std::nullopt;
  name.remove_suffix(tail.size());
  const auto begin = name.find_last_not_of("0123456789") + 1;
  int number = 0;
  const auto* end = name.data() + name.size();
  if (std::from_chars(name.data() + begin, end, number).ptr != end || begin == name.size()) return std::nullopt;
  return number;
}

const json* find_document(const std::vector<json>& documents, std::string_view bench) {
  for (const auto& document : documents) {
    if (document["bench"].get<std::string>() == bench) return &document;
  }
  return nullptr;
}

/// Rows of cases that start with `begin` and measure `metric`, by number of axes: number, median, 99.9 %. One block of
/// a gnuplot file.
std::string by_axes(const json& document, std::string_view begin, std::string_view metric) {
  std::string block = fmt::format("# {}{}\n", begin, metric);
  for (const auto& row : document["results"]) {
    const auto name = row["case"].get<std::string>();
    const auto axes = number_before(name, "_axes");
    if (!axes || !name.starts_with(begin) || row["metric"].get<std::string>() != metric) continue;
    block += fmt::format("{} {} {}\n", *axes, row["p50"].get<double>(), row["p999"].get<double>());
  }
  return block + "\n\n";
}

BenchFigure master_cost_figure(const json& document) {
  BenchFigure figure{"master_cost", {}, {}};
  for (const auto* metric : {"bare_af_packet_loop", "send_receive_decode", "bare_packet_mmap_loop"}) {
    figure.data += by_axes(document, "", metric);
  }
  figure.script = std::string(kSvgTerminal) +
                  "set output 'master_cost.svg'\n"
                  "set title 'one cycle on a packet socket'\nset xlabel 'axes'\nset ylabel 'ns'\n"
                  "set grid\nset key outside right\nset logscale xy\nset xtics (1, 8, 32, 100)\nset xrange [0.8:125]\n"
                  "plot 'master_cost.dat' index 1 using 1:2 with linespoints lw 3 title 'master, median', \\\n"
                  "  '' index 0 using 1:2 with linespoints lw 2 title 'bare AF_PACKET loop, median', \\\n"
                  "  '' index 2 using 1:2 with linespoints lw 2 title 'bare PACKET_MMAP loop, median', \\\n"
                  "  '' index 1 using 1:3 with linespoints dt 2 title 'master, 99.9 %', \\\n"
                  "  '' index 2 using 1:3 with linespoints dt 2 title 'bare PACKET_MMAP loop, 99.9 %'\n";
  return figure;
}

BenchFigure cycle_figure(const json& document) {
  BenchFigure figure{"cycle", {}, {}};
  for (const auto* pace : {"back_to_back_", "paced_"}) figure.data += by_axes(document, pace, "master_part_per_axis");
  figure.script = std::string(kSvgTerminal) +
                  "set output 'cycle.svg'\n"
                  "set title 'share of the master in a cycle'\nset xlabel 'axes'\nset ylabel 'ns per axis'\n"
                  "set grid\nset key outside right\nset logscale xy\nset xtics (1, 8, 32, 100)\nset xrange [0.8:125]\n"
                  "plot 150 with lines dt 3 lc 'gray' title 'aim: 150 ns', \\\n"
                  "  'cycle.dat' index 0 using 1:2 with linespoints lw 3 title 'back to back, median', \\\n"
                  "  '' index 1 using 1:2 with linespoints lw 3 title 'every 125 us, median', \\\n"
                  "  '' index 1 using 1:3 with linespoints dt 2 title 'every 125 us, 99.9 %'\n";
  return figure;
}

/// Wake-up latency: a curve through the percentiles for each method of waiting.
BenchFigure wake_figure(const json& document) {
  BenchFigure figure{"wake", {}, {}};
  std::string curves;
  std::string unit;
  int index = 0;
  for (const auto& row : document["results"]) {
    const auto name = row["case"].get<std::string>();
    unit = row["unit"].get<std::string>();
    figure.data += fmt::format("# {}\n50 {}\n99 {}\n99.9 {}\n100 {}\n\n\n", name, row["p50"].get<double>(),
                               row["p99"].get<double>(), row["p999"].get<double>(), row["max"].get<double>());
    curves += fmt::format("{}'wake.dat' index {} using 0:2:xtic(1) with linespoints lw 2 title '{}'",
                          index == 0 ? "" : ", \\\n  ", index, name);
    ++index;
  }
  figure.script = std::string(kSvgTerminal) +
                  "set output 'wake.svg'\n"
                  "set title 'wake-up after the grid time'\nset xlabel 'per cent of the cycles'\nset ylabel '" +
                  unit + "'\nset grid\nset key outside right\nset logscale y\nplot " + curves + "\n";
  return figure;
}

}  // namespace

std::string comparison_text(const json& row) {
  if (!row.contains("against")) return {};
  auto text = fmt::format("{:.2f} ({:.2f}) x {}", row.value("ratio_p50", 0.0), row.value("ratio_p999", 0.0),
                          row["against"].get<std::string>());
  if (!row.contains("ratio_turns")) return text;
  const auto& turns = row["ratio_turns"];
  return text + fmt::format("; by {} turns {:.2f} to {:.2f}", turns["turns"].get<std::uint64_t>(),
                            turns["low"].get<double>(), turns["high"].get<double>());
}

tl::expected<json, std::string> parse_bench_document(const std::string& text) {
  auto document = json::parse(text, nullptr, false);
  if (!document.is_object()) return tl::unexpected(std::string("printed no JSON document"));
  if (!document.contains("bench") || !document["bench"].is_string())
    return tl::unexpected(std::string("the document has no \"bench\""));
  if (!document.contains("environment") || !document["environment"].is_object())
    return tl::unexpected(std::string("the document has no \"environment\""));
  if (!document.contains("results") || !document["results"].is_array())
    return tl::unexpected(std::string("the document has no \"results\""));
  for (const auto& row : document["results"]) {
    if (!row.is_object()) return tl::unexpected(std::string("a result is not an object"));
    for (const auto key : kResultKeys) {
      if (!row.contains(key) || !row[std::string(key)].is_string())
        return tl::unexpected(fmt::format("a result has no \"{}\"", key));
    }
    for (const auto key : kFigures) {
      if (!row.contains(key) || !row[std::string(key)].is_number())
        return tl::unexpected(fmt::format("a result has no \"{}\"", key));
    }
    for (const auto problem : {histogram_problem, log_bins_problem, detail_problem}) {
      if (auto wrong = problem(row)) return tl::unexpected(std::move(*wrong));
    }
  }
  return document;
}

std::string bench_report(const std::vector<json>& documents) {
  auto text = "# Benchmarks\n" + aims_text(documents);
  for (const auto& document : documents) {
    const auto& where = document["environment"];
    text += fmt::format("\n## {}\n\n{}, {} ({} cores{}), {}, commit {}\n\n", document["bench"].get<std::string>(),
                        where.value("kernel", "?"), where.value("cpu", "?"), where.value("cores", 0),
                        where.value("virtual_machine", false) ? ", virtual machine" : "", where.value("compiler", "?"),
                        where.value("commit", "?"));
    if (document["results"].empty()) {
      text += "Skipped: it could not measure on this machine.\n";
      continue;
    }
    text += "| case | metric | unit | p50 | p99 | p99.9 | max | aim | against: p50 (p99.9) |\n";
    text += "|---|---|---|---:|---:|---:|---:|---|---|\n";
    for (const auto& row : document["results"]) text += row_text(row);
  }
  return text;
}

std::vector<BenchFigure> bench_figures(const std::vector<json>& documents) {
  std::vector<BenchFigure> figures;
  const auto draw = [&](std::string_view bench, BenchFigure (*make)(const json&)) {
    const auto* document = find_document(documents, bench);
    if (document == nullptr || (*document)["results"].empty()) return;
    // A document may lack the rows that would be drawn.
    if (auto figure = make(*document); !figure.script.empty()) figures.push_back(std::move(figure));
  };
  draw("cycle", cycle_figure);
  draw("master_cost", master_cost_figure);
  draw("roundtrip", roundtrip_figure);
  draw("scale", scale_figure);
  draw("soak", soak_figure);
  draw("wake", wake_figure);
  if (const auto* document = find_document(documents, "jitter")) {
    for (auto& figure : jitter_figures(*document)) figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace driveline::cli
