#include "text/bench_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

std::string head(std::string_view name, int height) {
  return fmt::format(
      "set terminal svg size 860,{} font 'sans,11' background 'white' noenhanced\nset output '{}.svg'\nset grid\n"
      "set key outside right\n",
      height, name);
}

/// Scale factor and name of the unit in which a figure over time is drawn.
std::pair<double, std::string> drawn_unit(const std::string& unit) {
  if (unit == "ns") return {1e-3, "us"};
  return {1.0, unit == "1" ? std::string("in a window") : unit};
}

/// A block of the data file: the middle of each window, with median, 99 % and maximum.
std::string course_block(const json& row, double scale) {
  const auto& course = row["over_time"];
  const auto window_s = course["window_s"].get<double>();
  auto block = fmt::format("# {}\n", row["metric"].get<std::string>());
  for (std::size_t i = 0; i < course["p50"].size(); ++i) {
    block += fmt::format("{:.6g}", (static_cast<double>(i) + 0.5) * window_s);
    for (const auto* key : {"p50", "p99", "max"}) block += fmt::format(" {:.6g}", course[key][i].get<double>() * scale);
    block += "\n";
  }
  return block + "\n\n";
}

/// Plots one curve for a metric with a single value per window, three for a distribution.
std::string course_plot(const json& row, int index, const std::string& unit) {
  const auto metric = row["metric"].get<std::string>();
  auto script = fmt::format("set ylabel {}\n", gnuplot_text(unit));
  if (!row.contains("histogram")) {
    return script +
           fmt::format(
               "unset logscale y\nset yrange [0:*]\nplot 'soak.dat' index {} using 1:2 with histeps lw 2 title {}\n",
               index, gnuplot_text(metric));
  }
  script += "set logscale y\nset yrange [*:*]\nplot ";
  int column = 2;
  for (const auto* name : {"p50", "p99", "max"}) {
    script += fmt::format("{}'soak.dat' index {} using 1:{} with lines lw 2 title {}", column == 2 ? "" : ", ", index,
                          column, gnuplot_text(fmt::format("{}, {}", metric, name)));
    ++column;
  }
  return script + "\n";
}

/// The first number in a name; 0: there is none.
double number_in(std::string_view name) {
  const auto digit = name.find_first_of("0123456789");
  return digit == std::string_view::npos ? 0.0 : std::strtod(std::string(name.substr(digit)).c_str(), nullptr);
}

/// Rows of a metric by the number at the start of their case, grouped by the part after the next word and ordered by
/// the number in that part: "32_axes_every_125_us" has the number 32 in the group "every_125_us" (125).
using Groups = std::map<std::pair<double, std::string>, std::map<double, const json*>>;

Groups by_number(const json& document, std::string_view metric) {
  Groups groups;
  for (const auto& row : document["results"]) {
    if (row["metric"].get<std::string>() != metric) continue;
    const auto name = row["case"].get<std::string>();
    const auto word = name.find('_');
    const auto rest = word == std::string::npos ? word : name.find('_', word + 1);
    if (name.find_first_not_of("0123456789") != word || rest == std::string::npos) continue;
    const auto group = name.substr(rest + 1);
    groups[{number_in(group), group}][number_in(name)] = &row;
  }
  return groups;
}

/// Adds a data block per group, and returns the plots of their medians.
std::string curves(BenchFigure& figure, const json& document, std::string_view metric, std::string_view prefix,
                   int& index) {
  std::string plots;
  for (const auto& [key, rows] : by_number(document, metric)) {
    auto title = key.second;
    std::replace(title.begin(), title.end(), '_', ' ');
    figure.data += fmt::format("# {} {}\n", key.second, metric);
    for (const auto& [number, row] : rows) figure.data += fmt::format("{} {}\n", number, (*row)["p50"].get<double>());
    figure.data += "\n\n";
    plots +=
        fmt::format("{}'{}.dat' index {} using 1:2 with linespoints lw 2 title {}", plots.empty() ? "" : ", \\\n  ",
                    figure.name, index++, gnuplot_text(fmt::format("{}{}", prefix, title)));
  }
  return plots;
}

}  // namespace

BenchFigure soak_figure(const json& document) {
  BenchFigure figure{"soak", {}, {}};
  std::string panels;
  double end_s = 0.0;
  int index = 0;
  for (const auto& row : document["results"]) {
    if (!row.contains("over_time") || row["over_time"]["p50"].empty()) continue;
    const auto [scale, unit] = drawn_unit(row["unit"].get<std::string>());
    figure.data += course_block(row, scale);
    panels += course_plot(row, index++, unit);
    end_s = row["over_time"]["window_s"].get<double>() * static_cast<double>(row["over_time"]["p50"].size());
  }
  if (index == 0) return figure;
  figure.script = head("soak", 60 + 190 * index) +
                  fmt::format(
                      "set multiplot layout {},1 title 'over time'\nset lmargin 11\nset rmargin 32\n"
                      "set xrange [0:{:.6g}]\nset xlabel 'time in s'\n{}unset multiplot\n",
                      index, end_s, panels);
  return figure;
}

BenchFigure scale_figure(const json& document) {
  BenchFigure figure{"scale", {}, {}};
  int index = 0;
  const auto costs = curves(figure, document, "master_part", "master, ", index);
  if (costs.empty()) return figure;
  figure.script = head("scale", 640) +
                  "set multiplot layout 2,1\nset lmargin 11\nset rmargin 34\nset logscale xy\nset xrange "
                  "[0.9:300]\nset xlabel 'axes'\n"
                  "set ylabel 'us, median'\nset xtics (1, 2, 4, 8, 16, 32, 64, 128, 256)\n"
                  "plot " +
                  costs +
                  "\nset xrange [50:5000]\nset xlabel 'cycle in us'\nset ylabel 'axes'\n"
                  "set xtics (62.5, 125, 250, 500, 1000, 2000, 4000)\nplot ";
  bool first = true;
  for (const auto* limit : {"limit_of_the_wire", "limit_of_this_machine", "limit_of_both"}) {
    figure.data += fmt::format("# {}\n", limit);
    for (const auto& row : document["results"]) {
      const auto name = row["case"].get<std::string>();
      if (row["metric"].get<std::string>() != limit || !name.starts_with("every_") || !name.ends_with("_us")) continue;
      figure.data += fmt::format("{} {}\n", name.substr(6, name.size() - 9), row["p50"].get<double>());
    }
    figure.data += "\n\n";
    figure.script += fmt::format("{}'scale.dat' index {} using 1:2 with linespoints lw 2 title '{}'", first ? "" : ", ",
                                 index++, limit);
    first = false;
  }
  figure.script += "\nunset multiplot\n";
  return figure;
}

BenchFigure roundtrip_figure(const json& document) {
  BenchFigure figure{"roundtrip", {}, {}};
  int index = 0;
  const auto ports = curves(figure, document, "round_trip", "port, ", index);
  const auto bare = curves(figure, document, "bare_round_trip", "bare loop, ", index);
  if (ports.empty() || bare.empty()) return figure;
  figure.script = head("roundtrip", 360) +
                  "set title 'round trip, median'\nset xlabel 'bytes'\nset ylabel 'ns'\n"
                  "set yrange [0:*]\nset xrange [0:1600]\nplot " +
                  ports + ", \\\n  " + bare + "\n";
  return figure;
}

}  // namespace driveline::cli
