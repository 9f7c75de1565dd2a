#include "text/jitter_figure.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

constexpr int kPanelHeight = 190;
/// Behind the deadline, for the bar of the periods that were missed; in us.
constexpr double kMissedAt = 6.0;
constexpr double kMissedWidth = 8.0;

/// The first word of a case, "idle" of "idle_cycle_pure_sleep", and the rest.
std::pair<std::string, std::string> state_and_way(const std::string& name) {
  const auto end = name.find('_');
  if (end == std::string::npos) return {name, name};
  return {name.substr(0, end), name.substr(end + 1)};
}

/// A vertical line with its name, at `us`.
std::string mark(int number, double us, const std::string& name, double height) {
  return fmt::format(
      "set arrow {0} from {1},graph 0 to {1},graph {3} nohead dt 3\nset label {0} {2} at {1},graph {3} offset 0.4,-0.5 "
      "font ',8'\n",
      number, us, gnuplot_text(name), height);
}

/// The counts below the deadline and those from it on, a block of the file each.
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

/// Draws the blocks 2 * `panel` and the one behind.
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
    // Beyond the deadline the bar tells.
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
    // An empty block is none to gnuplot, and those behind it would have other numbers.
    figure.data += blocks.in_time + (blocks.any_in_time ? "" : "-1 0\n") + "\n\n" + blocks.missed +
                   ((*row)["histogram"]["missed"].get<std::uint64_t>() > 0 ? "" : "-1 0\n") + "\n\n";
    figure.script += panel_script(*row, figure.name + ".dat", way, panel++, blocks);
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
  for (const auto& key : order) figures.push_back(figure_of(key.first, key.second, groups.at(key)));
  return figures;
}

}  // namespace driveline::cli
