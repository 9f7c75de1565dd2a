#include "text/jitter_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

constexpr int kPanelHeight = 190;
/// Distance from the deadline to the bar of the missed periods, and its width, in us.
constexpr double kMissedAt = 6.0;
constexpr double kMissedWidth = 8.0;
/// Space around the extra bars of a logarithmic axis, as a factor.
constexpr double kLogMargin = 1.8;
/// Space for the label of the longest delay, which is right of it, as a factor.
constexpr double kLabelRoom = 6.0;

/// Splits the name of a case: "idle_cycle_pure_sleep" into "idle" and "cycle_pure_sleep".
std::pair<std::string, std::string> state_and_way(const std::string& name) {
  const auto end = name.find('_');
  if (end == std::string::npos) return {name, name};
  return {name.substr(0, end), name.substr(end + 1)};
}

/// A vertical line at `us`, labelled with `name`.
std::string mark(int number, double us, const std::string& name, double height) {
  return fmt::format(
      "set arrow {0} from {1},graph 0 to {1},graph {3} nohead dt 3\nset label {0} {2} at {1},graph {3} offset 0.4,-0.5 "
      "font ',8'\n",
      number, us, gnuplot_text(name), height);
}

/// The counts below the deadline and those from the deadline on, one block of the file each.
struct Blocks {
  std::string in_time;
  std::string missed;
  bool any_in_time = false;
};

Blocks blocks_of(const json& histogram, const std::string& way) {
  const auto deadline_us = histogram["deadline_us"].get<double>();
  const auto missed = histogram["missed"].get<std::uint64_t>();
  Blocks blocks{fmt::format("# {}\n", way), fmt::format("# {}, missed\n", way)};
  for (const auto& bin : histogram["bins"]) {
    const auto us = bin[0].get<std::int64_t>();
    if (static_cast<double>(us) >= deadline_us) continue;
    blocks.in_time += fmt::format("{} {}\n", us, bin[1].get<std::uint64_t>());
    blocks.any_in_time = true;
  }
  if (missed > 0) blocks.missed += fmt::format("{} {}\n", deadline_us + kMissedAt, missed);
  return blocks;
}

/// Draws the two blocks from 2 * `panel` on.
std::string panel_script(const json& row, const std::string& file, const std::string& way, int panel,
                         const Blocks& blocks) {
  const auto& histogram = row["histogram"];
  const auto deadline_us = histogram["deadline_us"].get<double>();
  const auto us = [&row](const char* key) { return row[key].get<double>() / 1000.0; };
  auto script = fmt::format(
      "unset arrow\nunset label\nset arrow 1 from {0},graph 0 to {0},graph 1 nohead lw 2 lc 'red'\n", deadline_us);
  int number = 2;
  double height = 0.98;
  for (const auto& [name, key] :
       {std::pair{"p50", "p50"}, std::pair{"p99", "p99"}, std::pair{"p99.9", "p999"}, std::pair{"max", "max"}}) {
    // Values beyond the deadline are covered by the bar of the missed periods.
    if (us(key) < deadline_us) script += mark(number, us(key), fmt::format("{} {:.1f}", name, us(key)), height);
    ++number;
    height -= 0.14;
  }
  const auto missed = histogram["missed"].get<std::uint64_t>();
  const auto title = fmt::format("{}: {} instants, max {:.1f} us", way, row["n"].get<std::uint64_t>(), us("max"));
  script += blocks.any_in_time
                ? fmt::format("plot {} index {} using ($1+0.5):2:(1) with boxes lc rgb '#4477aa' title {}",
                              gnuplot_text(file), 2 * panel, gnuplot_text(title))
                : fmt::format("plot NaN title {}", gnuplot_text(title));
  script += missed > 0 ? fmt::format(", {} index {} using 1:2:({}) with boxes lc rgb 'red' title 'missed: {}'",
                                     gnuplot_text(file), 2 * panel + 1, kMissedWidth, missed)
                       : std::string(", NaN with boxes lc rgb 'red' title 'missed: none'");
  return script + "\n";
}

BenchFigure figure_of(const std::string& state, const std::string& metric, const std::vector<const json*>& rows) {
  BenchFigure figure{fmt::format("jitter_{}_{}", state, metric), {}, {}};
  const auto deadline_us = (*rows.front())["histogram"]["deadline_us"].get<double>();
  figure.script = fmt::format(
      "set terminal svg size 860,{} font 'sans,11' background 'white' noenhanced\nset output '{}.svg'\n"
      "set multiplot layout {},1 title {}\nset grid\nset logscale y\nset yrange [0.5:*]\nset xrange [-1:{}]\n"
      "set style fill solid 0.8\nset key outside top right horizontal\nset xlabel 'us'\nset ylabel 'instants'\n",
      kPanelHeight * static_cast<int>(rows.size()) + 40, figure.name, rows.size(),
      gnuplot_text(fmt::format("{}, {}; red line: the period", metric, state)), deadline_us + kMissedAt + kMissedWidth);
  int panel = 0;
  for (const auto* row : rows) {
    const auto way = state_and_way((*row)["case"].get<std::string>()).second;
    const auto blocks = blocks_of((*row)["histogram"], way);
    // Gnuplot ignores an empty block, which would renumber the following ones.
    figure.data += blocks.in_time + (blocks.any_in_time ? "" : "-1 0\n") + "\n\n" + blocks.missed +
                   ((*row)["histogram"]["missed"].get<std::uint64_t>() > 0 ? "" : "-1 0\n") + "\n\n";
    figure.script += panel_script(*row, figure.name + ".dat", way, panel++, blocks);
  }
  figure.script += "unset multiplot\n";
  return figure;
}

/// Bars of equal width on a logarithmic axis, in us: from, to, count. A block each for the bars in time, for times
/// below the resolution of the clock, and for missed periods at their delays; together they contain all measurements.
std::string log_blocks(const json& row, double lowest_us) {
  const auto& histogram = row["histogram"];
  const auto deadline_us = histogram["deadline_us"].get<double>();
  const auto per_decade = histogram["per_decade"].get<double>();
  const auto edge_us = [per_decade](std::int64_t bin) {
    return std::pow(10.0, static_cast<double>(bin) / per_decade) / 1000.0;
  };
  const auto missed = histogram["missed"].get<std::uint64_t>();
  const auto unresolved = histogram["unresolved"]["count"].get<std::uint64_t>();
  auto left = row["n"].get<std::uint64_t>() - missed - unresolved;
  std::string in_time;
  std::string too_late;
  for (const auto& bin : histogram["log_bins"]) {
    const auto from_us = edge_us(bin[0].get<std::int64_t>());
    const auto to_us = edge_us(bin[0].get<std::int64_t>() + 1);
    const auto count = bin[1].get<std::uint64_t>();
    // The bin that contains the deadline is split there: the rest of it was missed.
    const auto before = from_us < deadline_us ? std::min(left, count) : 0;
    if (before > 0) in_time += fmt::format("{:.6g} {:.6g} {}\n", from_us, std::min(to_us, deadline_us), before);
    if (before < count && to_us > deadline_us) {
      too_late += fmt::format("{:.6g} {:.6g} {}\n", std::max(from_us, deadline_us), to_us, count - before);
    }
    left -= before;
  }
  // Gnuplot ignores an empty block, which would renumber the following ones.
  const std::string nothing = "1 1 0\n";
  return (in_time.empty() ? nothing : in_time) +
         fmt::format("\n\n{:.6g} {:.6g} {}\n\n\n", lowest_us / kLogMargin, lowest_us / 1.1, unresolved) +
         (too_late.empty() ? nothing : too_late) + "\n\n";
}

std::string log_panel(const json& row, const std::string& file, const std::string& way, int panel) {
  const auto& histogram = row["histogram"];
  const auto deadline_us = histogram["deadline_us"].get<double>();
  const auto us = [&row](const char* key) { return row[key].get<double>() / 1000.0; };
  auto script = fmt::format(
      "unset arrow\nunset label\nset title {1} offset 0,-0.7\n"
      "set arrow 1 from {0},graph 0 to {0},graph 1 nohead lw 2 lc 'red'\n",
      deadline_us,
      gnuplot_text(fmt::format("{}: {} instants, max {:.1f} us", way, row["n"].get<std::uint64_t>(), us("max"))));
  int number = 2;
  double height = 0.98;
  for (const auto& [name, key] :
       {std::pair{"p50", "p50"}, std::pair{"p99", "p99"}, std::pair{"p99.9", "p999"}, std::pair{"max", "max"}}) {
    if (us(key) > 0.0) script += mark(number, us(key), fmt::format("{} {:.2f}", name, us(key)), height);
    ++number;
    height -= 0.14;
  }
  const auto box = [&](int block, const char* color, const std::string& title) {
    return fmt::format(
        "{} index {} using (sqrt($1*$2)):3:1:2:(0.5):3 with boxxyerror fs solid 0.8 lc rgb '{}' title {}",
        gnuplot_text(file), 3 * panel + block, color, gnuplot_text(title));
  };
  return script + "plot " + box(0, "#4477aa", "in time") + ", " +
         box(1, "#999999", fmt::format("unresolved: {}", histogram["unresolved"]["count"].get<std::uint64_t>())) +
         ", " + box(2, "red", fmt::format("missed: {}", histogram["missed"].get<std::uint64_t>())) + "\n";
}

/// The same distributions in bars of equal width on a logarithmic axis; none if a row has no such bins.
std::optional<BenchFigure> log_figure_of(const std::string& state, const std::string& metric,
                                         const std::vector<const json*>& rows) {
  double lowest_us = 1e9;
  double highest_us = 0.0;
  for (const auto* row : rows) {
    const auto& histogram = (*row)["histogram"];
    if (!histogram.contains("log_bins") || histogram["deadline_us"].get<double>() <= 0.0) return std::nullopt;
    const auto below = histogram["unresolved"]["below_bin"].get<double>();
    lowest_us = std::min(lowest_us, std::pow(10.0, below / histogram["per_decade"].get<double>()) / 1000.0);
    highest_us = std::max({highest_us, histogram["deadline_us"].get<double>(), (*row)["max"].get<double>() / 1000.0});
  }
  BenchFigure figure{fmt::format("jitter_{}_{}_log", state, metric), {}, {}};
  figure.script = fmt::format(
      "set terminal svg size 860,{} font 'sans,11' background 'white' noenhanced\nset output '{}.svg'\n"
      "set multiplot layout {},1 title {}\nset grid\nset logscale xy\nset yrange [0.5:*]\nset xrange [{:.6g}:{:.6g}]\n"
      "set key outside right top\nset lmargin 11\nset rmargin 24\nset xlabel 'us'\nset ylabel 'instants'\n",
      kPanelHeight * static_cast<int>(rows.size()) + 40, figure.name, rows.size(),
      gnuplot_text(fmt::format("{}, {}; red line: the period", metric, state)), lowest_us / kLogMargin / 1.1,
      highest_us * kLabelRoom);
  int panel = 0;
  for (const auto* row : rows) {
    const auto way = state_and_way((*row)["case"].get<std::string>()).second;
    figure.data += fmt::format("# {}\n", way) + log_blocks(*row, lowest_us);
    figure.script += log_panel(*row, figure.name + ".dat", way, panel++);
  }
  figure.script += "unset multiplot\n";
  return figure;
}

}  // namespace

std::vector<BenchFigure> jitter_figures(const json& document) {
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, std::vector<const json*>> groups;
  for (const auto& row : document["results"]) {
    if (!row.contains("histogram")) continue;
    const std::pair key{state_and_way(row["case"].get<std::string>()).first, row["metric"].get<std::string>()};
    if (!groups.contains(key)) order.push_back(key);
    groups[key].push_back(&row);
  }
  std::vector<BenchFigure> figures;
  for (const auto& key : order) {
    figures.push_back(figure_of(key.first, key.second, groups.at(key)));
    if (auto figure = log_figure_of(key.first, key.second, groups.at(key))) figures.push_back(std::move(*figure));
  }
  return figures;
}

}  // namespace driveline::cli
