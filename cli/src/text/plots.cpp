#include "text/plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "driveline/runtime/files/output_file.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kTerminal = "set terminal pngcairo size 1400,{height} font 'sans,11' noenhanced\n";

std::string terminal(int height) {
  return fmt::format(fmt::runtime(kTerminal), fmt::arg("height", height));
}

/// Limit of the marks in a picture; more would make it unreadable.
constexpr std::size_t kMaxMarks = 60;

double log_us(std::chrono::nanoseconds time) {
  return std::log10(static_cast<double>(time.count()) / 1000.0);
}

/// Draws a distribution of jitter.csv: bars a tenth of a decade wide, on an axis of logarithms of microseconds. Gnuplot
/// adds up the counts that fall into the same bar, so nothing is lost.
std::string jitter_panel(int column, const std::string& title, std::chrono::nanoseconds deadline,
                         const std::array<std::chrono::nanoseconds, 4>& figures) {
  const auto us = [&figures](std::size_t i) { return static_cast<double>(figures[i].count()) / 1000.0; };
  const auto whole = fmt::format("{}: p50 {:.2f} us, p99 {:.2f} us, p99.9 {:.2f} us, max {:.2f} us", title, us(0),
                                 us(1), us(2), us(3));
  std::string script = fmt::format("unset arrow\nunset label\nset title {}\ndeadline = {}\n", gnuplot_text(whole),
                                   deadline.count() > 0 ? deadline.count() : std::chrono::nanoseconds::max().count());
  if (deadline.count() > 0) {
    script +=
        fmt::format("set arrow 9 from {0:.4f},graph 0 to {0:.4f},graph 1 nohead lw 2 lc 'red'\n", log_us(deadline));
  }
  int number = 1;
  for (const auto* name : {"p50", "p99", "p99.9", "max"}) {
    const auto time = figures[static_cast<std::size_t>(number) - 1];
    const bool shown = time.count() >= 25 && (deadline.count() == 0 || time < deadline);
    if (shown) {
      script += fmt::format(
          "set arrow {0} from {1:.4f},graph 0 to {1:.4f},graph 1 nohead dt 3\n"
          "set label {0} '{2} {3:.2f} us' at {1:.4f},graph {4:.2f} offset 0.4,0 font ',9'\n",
          number, log_us(time), name, static_cast<double>(time.count()) / 1000.0, 1.0 - 0.07 * number);
    }
    ++number;
  }
  script += fmt::format(
      "plot 'jitter.csv' skip 1 using (bar($1,$2)):($1>=25 && $1<deadline ? ${0} : 0) smooth frequency with boxes "
      "lc rgb '#4477aa' title 'cycles', \\\n"
      "     '' skip 1 using (-2.0):($1<25 ? ${0} : 0) smooth frequency with boxes lc rgb '#999999' title 'below 25 ns'",
      column);
  if (deadline.count() == 0) return script + "\n";
  return script + fmt::format(
                      ", \\\n     '' skip 1 using ({:.4f}):($1>=deadline ? ${} : 0) smooth frequency with boxes lc rgb "
                      "'red' title 'missed periods'\n",
                      log_us(deadline) + 0.3, column);
}

std::string jitter_script(const PlotFacts& facts) {
  return terminal(800) +
         "set output 'jitter.png'\n"
         "set datafile separator ','\n"
         // The sum of both columns is twice the number of cycles. Without this range gnuplot fails if a kind of bars
         // has no counts.
         "stats 'jitter.csv' skip 1 using ($3+$4) nooutput\n"
         "set multiplot layout 2,1\n"
         "set ylabel 'cycles'\nset xlabel 'time'\n"
         "set logscale y\nset grid\nset style fill solid 0.7\nset boxwidth 0.1\nset key outside right\n"
         "set yrange [0.5:STATS_sum+2]\nset xrange [-2.2:*]\n"
         "set xtics ('< 25 ns' -2, '100 ns' -1, '1 us' 0, '10 us' 1, '100 us' 2, '1 ms' 3, '10 ms' 4, '100 ms' 5, '1 "
         "s' 6)\n"
         "bar(from, to) = (floor(10*log10((from + to) / 2000.0)) + 0.5) / 10\n" +
         jitter_panel(3, "wake-up latency", facts.period, facts.wake) +
         jitter_panel(4, "cost of the cycle", std::chrono::nanoseconds{0}, facts.cost) + "unset multiplot\n";
}

/// Draws vertical lines at events, red where the master was away.
std::string marks_script(const std::vector<PlotMark>& marks) {
  std::string script;
  int number = 1;
  for (const auto& mark : marks) {
    const auto* color = mark.missed ? "#dd181f" : "#606060";
    script += fmt::format("set arrow {0} from {1:.6f},graph 0 to {1:.6f},graph 1 nohead dt 2 lc rgb '{2}'\n", number,
                          mark.time_s, color);
    // Missed periods come in bursts, so their colour must do without labels.
    if (!mark.missed) {
      script += fmt::format("set label {} {} at {:.6f},graph 0.02 rotate by 90 font ',8' tc rgb '{}' offset 0.5,0\n",
                            number, gnuplot_text(mark.text), mark.time_s, color);
    }
    ++number;
  }
  return script;
}

/// The same curve on the second axis in increments, but invisible, so that both axes have the range of the data.
std::string on_second_axis(std::string_view column, double increments, std::string_view rows = "") {
  return fmt::format(", '' skip 1{} using 1:(({})*{:.17g}) axes x1y2 with lines lt nodraw notitle", rows, column,
                     increments);
}

/// A small plot of an axis.
class AxisPlot {
 public:
  /// `increments`: adds a second axis in increments.
  AxisPlot(const runtime::AxisRunReport& axis, bool increments)
      : scale_(increments ? std::optional(axis.increments_per_unit) : std::nullopt) {
    text_ = fmt::format("set ylabel {}\n", gnuplot_text(fmt::format("{} in {}", axis.name, axis.unit)));
    if (scale_) {
      text_ +=
          "set yrange [*:*] noextend\nset y2range [*:*] noextend\nset ytics nomirror\nset y2tics format '%.0f'\n"
          "set y2label 'increments'\n";
    }
    text_ += "plot 'axes.csv' skip 1";
  }

  /// Adds a curve of a column, drawn `with` this style.
  void add(std::size_t column, std::string_view with) {
    text_ += fmt::format("{} using 1:{} {}", begun_ ? ", '' skip 1" : "", column, with);
    begun_ = true;
    if (scale_) text_ += on_second_axis(fmt::format("${}", column), *scale_);
  }

  /// Fills the area between two columns.
  void fill(std::size_t lower, std::size_t upper, std::string_view with) {
    text_ += fmt::format("{} using 1:{}:{} {}", begun_ ? ", '' skip 1" : "", lower, upper, with);
    begun_ = true;
  }

  /// `around`: a column. If the axis does not move, the range is one increment to either side of it.
  [[nodiscard]] std::string finish(std::size_t around) const {
    if (!scale_) return text_ + "\n";
    auto text = text_;
    for (const auto* sign : {"+", "-"}) {
      const auto beside = fmt::format("${}{}{:.17g}", around, sign, 1.0 / *scale_);
      text += fmt::format(", '' skip 1 every ::::0 using 1:({}) with lines lt nodraw notitle", beside) +
              on_second_axis(beside, *scale_, " every ::::0");
    }
    return text + "\n";
  }

 private:
  std::optional<double> scale_;
  std::string text_;
  bool begun_ = false;
};

/// Column numbers of an axis in axes.csv: time, three columns per axis, their torques, minimum and maximum following
/// error of each, then the following errors and the demands of the drives that report them (Recorder).
struct AxisColumns {
  std::size_t commanded;
  std::size_t least;  ///< least following error; the next column is the greatest
};

AxisColumns columns_of(std::size_t axis, std::size_t axes) {
  return {2 + 3 * axis, 2 + 4 * axes + 2 * axis};
}

/// Adds the range of the following error between the rows of the file, so that no maximum is lost.
void add_error_band(AxisPlot& plot, const AxisColumns& columns) {
  plot.fill(columns.least, columns.least + 1, "with filledcurves lt 1 notitle");
  plot.add(columns.least, "with lines lt 1 title 'minimum and maximum'");
  plot.add(columns.least + 1, "with lines lt 1 notitle");
}

/// Starts a picture of the axes, two side by side, with `panels` plots per axis, one below the other.
std::string axes_head(std::size_t axes, std::size_t panels, std::string_view output, std::string_view title) {
  const std::size_t columns = axes > 1 ? 2 : 1;
  const auto rows = panels * ((axes + columns - 1) / columns);
  return "reset\n" + terminal(static_cast<int>(std::max<std::size_t>(rows, 2) * (panels > 1 ? 200 : 250))) +
         fmt::format(
             "set output '{}'\nset datafile separator ','\nset multiplot layout {},{} title '{}'\nset grid\n"
             "set key outside right samplen 2\nset lmargin 11\nset rmargin 24\nset autoscale xfix\nset xlabel 'time in "
             "s'\n",
             output, rows, columns, title);
}

/// Column of the first demand that a drive reports.
std::size_t first_demand(const std::vector<runtime::AxisRunReport>& axes) {
  const auto reporting = std::count_if(axes.begin(), axes.end(), [](const auto& axis) { return axis.by_drive; });
  return 2 + 6 * axes.size() + static_cast<std::size_t>(reporting);
}

/// Draws commanded position, demand of the drive and actual position, and the following error below.
std::string positions_script(const std::vector<runtime::AxisRunReport>& axes, bool increments,
                             const std::vector<PlotMark>& marks) {
  auto script = axes_head(axes.size(), 2, "positions.png",
                          "commanded and actual position; below, the following error; red lines: periods missed") +
                marks_script(marks);
  auto demand = first_demand(axes);
  for (std::size_t first = 0; first < axes.size(); first += 2) {
    const auto end = std::min(axes.size(), first + 2);
    for (auto i = first; i < end; ++i) {
      AxisPlot plot(axes[i], increments);
      const auto columns = columns_of(i, axes.size());
      // Draw the actual position over a wide pale band, so that both stay visible where they are equal.
      plot.add(columns.commanded, "with lines lw 4 lc rgb '#9ecae1' title 'commanded'");
      if (axes[i].demand_recorded) plot.add(demand++, "with lines lc rgb '#238b45' title 'demand (6062h)'");
      plot.add(columns.commanded + 1, "with lines lc rgb '#08306b' title 'actual'");
      script += plot.finish(columns.commanded);
    }
    // With an odd number of axes, the last one has no neighbour.
    if (end == first + 1 && axes.size() > 1) script += "set multiplot next\n";
    for (auto i = first; i < end; ++i) {
      AxisPlot plot(axes[i], increments);
      const auto columns = columns_of(i, axes.size());
      add_error_band(plot, columns);
      script += plot.finish(columns.least);
    }
  }
  return script + "unset multiplot\n";
}

std::string errors_script(const std::vector<runtime::AxisRunReport>& axes, bool increments,
                          const std::vector<PlotMark>& marks) {
  auto script = axes_head(axes.size(), 1, "following_error.png", "following error; red lines: periods missed") +
                marks_script(marks);
  auto reported = 2 + 6 * axes.size();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    AxisPlot plot(axes[i], increments);
    const auto columns = columns_of(i, axes.size());
    add_error_band(plot, columns);
    if (axes[i].by_drive) plot.add(reported++, "with lines lt 2 title 'by the drive (60F4h)'");
    script += plot.finish(columns.least);
  }
  return script + "unset multiplot\n";
}

}  // namespace

PlotFacts plot_facts(const runtime::RunReport& report) {
  const auto of = [](const rt::Histogram& histogram) {
    return std::array{histogram.percentile(0.5), histogram.percentile(0.99), histogram.percentile(0.999),
                      histogram.max()};
  };
  PlotFacts facts{report.period, of(report.statistics.wake_latency), of(report.statistics.cost), {}};
  if (report.statistics.missed_periods > 0)
    facts.marks.push_back({report.longest_absence_at_s, true, "longest absence"});
  for (const auto& event : report.events) {
    if (facts.marks.size() == kMaxMarks) break;
    if (!event.time || event.severity < runtime::Severity::kNotice) continue;
    const bool away = event.is<runtime::events::MasterAway>() || event.is<runtime::events::MasterAwayOften>();
    facts.marks.push_back({std::chrono::duration<double>(*event.time).count(), away,
                           away               ? "periods missed"
                           : event.is_fault() ? "fault"
                                              : "event"});
  }
  return facts;
}

runtime::Result<void> write_jitter_csv(const ecat_master::CycleStatistics& statistics,
                                       const std::filesystem::path& file) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::array<std::uint64_t, 2>> rows;
  auto add = [&rows](const rt::Histogram& histogram, std::size_t column) {
    histogram.for_each_bucket([&](const rt::Histogram::Bucket& bucket) {
      rows[{bucket.lower.count(), bucket.upper.count()}][column] += bucket.count;
    });
  };
  add(statistics.wake_latency, 0);
  add(statistics.cost, 1);
  std::string text = "from[ns],to[ns],wake_latency,cycle_cost\n";
  for (const auto& [bounds, counts] : rows) {
    text += fmt::format("{},{},{},{}\n", bounds.first, bounds.second, counts[0], counts[1]);
  }
  return runtime::write_file(file, text);
}

tl::expected<Drawing, std::string> draw_plots(const std::filesystem::path& directory,
                                              const std::vector<runtime::AxisRunReport>& axes, bool increments,
                                              const PlotFacts& facts) {
  auto script = jitter_script(facts);
  std::map<std::string, std::string> pictures{{"jitter_plot", "jitter.png"}};
  if (!axes.empty()) {
    script += positions_script(axes, increments, facts.marks) + errors_script(axes, increments, facts.marks);
    pictures["position_plot"] = "positions.png";
    pictures["following_error_plot"] = "following_error.png";
  }
  return draw(directory, "plots.gp", script, pictures);
}

tl::expected<Drawing, std::string> draw_clocks(const std::filesystem::path& directory,
                                               const std::vector<std::string>& names) {
  auto script = terminal(700) +
                "set output 'clocks.png'\nset datafile separator ','\nset grid\nset key outside right\n"
                "set title 'clocks against the reference clock (register 0x092C)'\n"
                "set xlabel 'time in s'\nset ylabel 'difference in ns'\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    script += fmt::format("{} 'clocks.csv' skip 1 using 1:{} with lines title {}", i == 0 ? "plot" : ",", i + 2,
                          gnuplot_text(names[i]));
  }
  return draw(directory, "clocks.gp", script + '\n', {{"clocks_plot", "clocks.png"}});
}

}  // namespace driveline::cli
