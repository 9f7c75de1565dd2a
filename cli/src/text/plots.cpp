#include "text/plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "driveline/runtime/files/output_file.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kTerminal = "set terminal pngcairo size 1400,{height} font 'sans,11' noenhanced\n";

std::string terminal(int height) {
  return fmt::format(fmt::runtime(kTerminal), fmt::arg("height", height));
}

std::string jitter_script() {
  return terminal(600) +
         "set output 'jitter.png'\n"
         "set datafile separator ','\n"
         "set title 'wake-up latency and cycle cost'\n"
         "set xlabel 'time in us'\nset ylabel 'cycles'\n"
         "set logscale xy\nset grid\nset style fill solid 0.5\n"
         "set xrange [0.01:*]\nset yrange [0.5:*]\n"
         // Middle of the bucket; values below 10 ns are drawn at the left edge of the logarithmic axis.
         "us(from, to) = from + to < 20 ? 0.01 : (from + to) / 2000.0\n"
         "plot 'jitter.csv' skip 1 using (us($1,$2)):3 with impulses lw 2 title 'wake-up latency', \\\n"
         "     '' skip 1 using (us($1,$2)):4 with impulses lw 2 title 'cycle cost'\n";
}

/// The same curve on the second axis, where increments are, but not drawn: both axes then have the range of the data.
std::string on_second_axis(std::string_view column, double increments, std::string_view rows = "") {
  return fmt::format(", '' skip 1{} using 1:(({})*{:.17g}) axes x1y2 with lines lt nodraw notitle", rows, column,
                     increments);
}

/// One small plot of an axis.
class AxisPlot {
 public:
  /// `increments`: on a second axis as well.
  AxisPlot(const runtime::AxisReport& axis, bool increments)
      : scale_(increments ? std::optional(axis.increments_per_unit) : std::nullopt) {
    text_ = fmt::format("set ylabel {}\n", gnuplot_text(fmt::format("{} in {}", axis.name, axis.unit)));
    if (scale_) {
      text_ +=
          "set yrange [*:*] noextend\nset y2range [*:*] noextend\nset ytics nomirror\nset y2tics format '%.0f'\n"
          "set y2label 'increments'\n";
    }
    text_ += "plot 'axes.csv' skip 1";
  }

  /// A curve of a column, drawn `with`.
  void add(std::size_t column, std::string_view with) {
    text_ += fmt::format("{} using 1:{} {}", begun_ ? ", '' skip 1" : "", column, with);
    begun_ = true;
    if (scale_) text_ += on_second_axis(fmt::format("${}", column), *scale_);
  }

  /// Between two columns.
  void fill(std::size_t lower, std::size_t upper, std::string_view with) {
    text_ += fmt::format("{} using 1:{}:{} {}", begun_ ? ", '' skip 1" : "", lower, upper, with);
    begun_ = true;
  }

  /// `around`: a column. Where nothing moves the range is one increment to either side.
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

/// One small plot per axis, two side by side. Columns of the file: time, three per axis, their torques, least and
/// greatest following error of each, then the following errors of the drives that report one (Recorder).
std::string axes_script(const std::vector<runtime::AxisReport>& axes, std::string_view output, std::string_view title,
                        bool errors, bool increments) {
  const std::size_t columns = axes.size() > 1 ? 2 : 1;
  const auto rows = (axes.size() + columns - 1) / columns;
  auto script = "reset\n" + terminal(static_cast<int>(std::max<std::size_t>(rows, 2) * 250));
  script += fmt::format(
      "set output '{}'\nset datafile separator ','\nset multiplot layout {},{} title '{}'\nset grid\nset key above\n"
      "set xlabel 'time in s'\n",
      output, rows, columns, title);
  auto reported = 2 + 6 * axes.size();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    AxisPlot plot(axes[i], increments);
    if (errors) {
      const auto least = 2 + 4 * axes.size() + 2 * i;
      plot.fill(least, least + 1, "with filledcurves lt 1 notitle");
      plot.add(least, "with lines lt 1 title 'least and greatest'");
      plot.add(least + 1, "with lines lt 1 notitle");
      if (axes[i].by_drive) plot.add(reported++, "with lines lt 2 title 'by the drive (60F4h)'");
      script += plot.finish(least);
    } else {
      const auto column = 2 + 3 * i;
      // The actual position upon a broad and pale band: where both are the same both can be seen.
      plot.add(column, "with lines lw 4 lc rgb '#9ecae1' title 'commanded'");
      plot.add(column + 1, "with lines lc rgb '#08306b' title 'actual'");
      script += plot.finish(column);
    }
  }
  return script + "unset multiplot\n";
}

}  // namespace

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

tl::expected<std::map<std::string, std::filesystem::path>, std::string> draw_plots(
    const std::filesystem::path& directory, const std::vector<runtime::AxisReport>& axes, bool increments) {
  const auto script_file = directory / "plots.gp";
  auto script = jitter_script();
  std::map<std::string, std::filesystem::path> pictures{{"jitter_plot", directory / "jitter.png"}};
  if (!axes.empty()) {
    script += axes_script(axes, "positions.png", "commanded and actual position", false, increments) +
              axes_script(axes, "following_error.png", "following error", true, increments);
    pictures["position_plot"] = directory / "positions.png";
    pictures["following_error_plot"] = directory / "following_error.png";
  }
  if (auto written = runtime::write_file(script_file, script); !written)
    return tl::unexpected(runtime::describe(written.error()));
  if (auto drawn = run_gnuplot(directory, "plots.gp"); !drawn) return tl::unexpected(drawn.error());
  return pictures;
}

tl::expected<std::filesystem::path, std::string> draw_clocks(const std::filesystem::path& directory,
                                                             const std::vector<std::string>& names) {
  auto script = terminal(700) +
                "set output 'clocks.png'\nset datafile separator ','\nset grid\nset key outside right\n"
                "set title 'clocks against the reference clock (register 0x092C)'\n"
                "set xlabel 'time in s'\nset ylabel 'difference in ns'\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    script += fmt::format("{} 'clocks.csv' skip 1 using 1:{} with lines title {}", i == 0 ? "plot" : ",", i + 2,
                          gnuplot_text(names[i]));
  }
  if (auto written = runtime::write_file(directory / "clocks.gp", script + '\n'); !written)
    return tl::unexpected(runtime::describe(written.error()));
  if (auto drawn = run_gnuplot(directory, "clocks.gp"); !drawn) return tl::unexpected(drawn.error());
  return directory / "clocks.png";
}

}  // namespace driveline::cli
