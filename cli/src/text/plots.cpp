#include "text/plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// Times below the resolution of the clock have a bar of their own, here on the axis of logarithms.
constexpr std::int64_t kResolutionNs = 25;
constexpr double kUnresolvedAt = -2.0;

/// End of the axis: all that was measured, and the deadline.
double end_of_axis(const PlotFacts& facts) {
  constexpr double kLeastEnd = 0.2;
  constexpr double kMargin = 0.2;
  const auto longest = std::max({facts.period, facts.wake.back(), facts.cost.back()});
  return longest.count() > 0 ? std::max(log_us(longest) + kMargin, kLeastEnd) : kLeastEnd;
}

/// Vertical lines at the percentiles, with labels below one another.
std::string percentile_marks(const std::array<std::chrono::nanoseconds, 4>& figures, double end) {
  std::string script;
  int number = 1;
  for (const auto* name : {"p50", "p99", "p99.9", "max"}) {
    const auto time = figures[static_cast<std::size_t>(number) - 1];
    if (time.count() >= kResolutionNs) {
      // A label near the right end is left of its line, or the picture would cut it.
      const bool left = log_us(time) > kUnresolvedAt + 0.85 * (end - kUnresolvedAt);
      script += fmt::format(
          "set arrow {0} from {1:.4f},graph 0 to {1:.4f},graph 1 nohead dt 3\n"
          "set label {0} '{2} {3:.2f} us' at {1:.4f},graph {4:.2f} front boxed {5} font ',9'\n",
          number, log_us(time), name, static_cast<double>(time.count()) / 1000.0, 1.03 - 0.07 * number,
          left ? "right offset -0.4,0" : "offset 0.4,0");
    }
    ++number;
  }
  return script;
}

/// Draws a distribution of jitter.csv: bars a tenth of a decade wide, on an axis of logarithms of microseconds. Gnuplot
/// adds up the counts that fall into the same bar, so nothing is lost. Bars from the deadline on are the missed
/// periods; one begins at the deadline, so none has both.
std::string jitter_panel(int column, const std::string& title, std::chrono::nanoseconds deadline,
                         const std::array<std::chrono::nanoseconds, 4>& figures, double end) {
  const auto us = [&figures](std::size_t i) { return static_cast<double>(figures[i].count()) / 1000.0; };
  const bool has_deadline = deadline.count() > 0;
  auto script = fmt::format("unset arrow\nunset label\nset title {}\ndeadline = {}\norigin = {}\n",
                            gnuplot_text(fmt::format("{}: p50 {:.2f} us, p99 {:.2f} us, p99.9 {:.2f} us, max {:.2f} us",
                                                     title, us(0), us(1), us(2), us(3))),
                            has_deadline ? deadline.count() : std::chrono::nanoseconds::max().count(),
                            has_deadline ? "log10(deadline / 1000.0)" : "0");
  if (has_deadline) {
    script +=
        fmt::format("set arrow 9 from {0:.4f},graph 0 to {0:.4f},graph 1 nohead lw 2 lc 'red'\n", log_us(deadline));
  }
  script += percentile_marks(figures, end);
  script += fmt::format(
      "plot 'jitter.csv' skip 1 using (bar($1)):($1>={1} && $1<deadline ? ${0} : 0) smooth frequency with boxes "
      "lc rgb '#4477aa' title 'cycles', \\\n     '' skip 1 using ({2}):($1<{1} ? ${0} : 0) smooth frequency with "
      "boxes lc rgb '#999999' title 'below {1} ns'",
      column, kResolutionNs, kUnresolvedAt);
  if (!has_deadline) return script + "\n";
  return script + fmt::format(
                      ", \\\n     '' skip 1 using (bar($1)):($1>=deadline ? ${} : 0) smooth frequency with boxes lc "
                      "rgb 'red' title 'a period or more too late'\n",
                      column);
}

std::string jitter_script(const PlotFacts& facts) {
  const double end = end_of_axis(facts);
  return terminal(800) +
         "set output 'jitter.png'\n"
         "set datafile separator ','\n"
         // The sum of both columns is twice the number of cycles. Without this range gnuplot fails if a kind of bars
         // has no counts. The labels of the percentiles need the upper third.
         "stats 'jitter.csv' skip 1 using ($3+$4) nooutput\n"
         "set multiplot layout 2,1\n"
         "set ylabel 'cycles'\nset xlabel 'time'\n"
         "set logscale y\nset grid\nset style fill solid 0.7\nset boxwidth 0.1\nset style textbox opaque noborder\n"
         "set key tmargin right horizontal samplen 2\n"
         "set yrange [0.5:0.5*(2*STATS_sum+4)**1.5]\n" +
         fmt::format("set xrange [-2.2:{:.4f}]\n", end) +
         "set xtics ('< 25 ns' -2, '100 ns' -1, '1 us' 0, '10 us' 1, '100 us' 2, '1 ms' 3, '10 ms' 4, '100 ms' 5, '1 "
         "s' 6)\n"
         // `ns` is at least 1 here: times below the resolution are not drawn by this.
         "bar(ns) = (floor(10*(log10((ns > 1 ? ns : 1)/1000.0) - origin)) + 0.5) / 10 + origin\n" +
         jitter_panel(3, "wake-up latency", facts.period, facts.wake, end) +
         jitter_panel(4, "cost of the cycle", std::chrono::nanoseconds{0}, facts.cost, end) + "unset multiplot\n";
}

}  // namespace

PlotFacts plot_facts(const runtime::RunReport& report) {
  const auto of = [](const rt::Histogram& histogram) {
    return std::array{histogram.percentile(0.5), histogram.percentile(0.99), histogram.percentile(0.999),
                      histogram.max()};
  };
  PlotFacts facts{report.period, of(report.statistics.wake_latency), of(report.statistics.cost), {}};
  // The recording of a long run has only its end, so the last events count.
  for (auto next = report.events.rbegin(); next != report.events.rend() && facts.marks.size() < kMaxMarks; ++next) {
    const auto& event = *next;
    if (!event.time || event.severity < runtime::Severity::kNotice) continue;
    const bool away = event.is<runtime::events::MasterAway>() || event.is<runtime::events::MasterAwayOften>();
    facts.marks.push_back(
        {std::chrono::duration<double>(*event.time).count(), away, describe(event, report.increments)});
  }
  std::reverse(facts.marks.begin(), facts.marks.end());
  if (report.statistics.missed_periods > 0)
    facts.marks.push_back({report.longest_absence_at_s, true, "the longest absence of the master"});
  return facts;
}

runtime::Result<void> write_jitter_csv(const motion::CycleStatistics& statistics, const std::filesystem::path& file) {
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
    const AxisPlots plots(axes, increments, facts.marks, column_ranges(directory / "axes.csv"));
    script += plots.positions() + plots.errors();
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
