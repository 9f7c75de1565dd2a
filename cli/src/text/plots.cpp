#include "text/plots.hpp"

#include <fmt/format.h>

#include "output_file.hpp"
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
         // Middle of the bucket; what is below 10 ns is drawn at the left edge of the logarithmic axis.
         "us(from, to) = from + to < 20 ? 0.01 : (from + to) / 2000.0\n"
         "plot 'jitter.csv' skip 1 using (us($1,$2)):3 with impulses lw 2 title 'wake-up latency', \\\n"
         "     '' skip 1 using (us($1,$2)):4 with impulses lw 2 title 'cycle cost'\n";
}

/// One small plot per axis, two side by side. The columns: time, three per axis, their torques, least and greatest
/// following error of each, then the following errors of the drives that report one (Recorder).
std::string axes_script(const std::vector<AxisReport>& axes, std::string_view output, std::string_view title,
                        bool errors) {
  const auto rows = (axes.size() + 1) / 2;
  auto script = "reset\n" + terminal(static_cast<int>(std::max<std::size_t>(rows, 2) * 230));
  script += fmt::format(
      "set output '{}'\nset datafile separator ','\nset multiplot layout {},2 title '{}'\nset grid\n"
      "set xlabel 'time in s'\n",
      output, rows, title);
  auto reported = 2 + 6 * axes.size();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto& axis = axes[i];
    const auto column = 2 + 3 * i;
    script += fmt::format("set ylabel {}\n",
                          gnuplot_text(fmt::format("{}: {}", axis.name, errors ? "increments" : axis.si_unit)));
    if (errors) {
      const auto least = 2 + 4 * axes.size() + 2 * i;
      script += fmt::format(
          "plot 'axes.csv' skip 1 using 1:(${0}*{2:.9g}):(${1}*{2:.9g}) with filledcurves lt 1 notitle, "
          "'' skip 1 using 1:(${0}*{2:.9g}) with lines lt 1 title 'following error, least and greatest', "
          "'' skip 1 using 1:(${1}*{2:.9g}) with lines lt 1 notitle",
          least, least + 1, axis.increments_per_unit);
      if (axis.by_drive) {
        script += fmt::format(", '' skip 1 using 1:(${}*{:.9g}) with lines title 'by the drive (60F4h)'", reported++,
                              axis.increments_per_unit);
      }
      script += '\n';
    } else {
      script += fmt::format(
          "plot 'axes.csv' skip 1 using 1:{} with lines lw 3 title 'commanded', "
          "'' skip 1 using 1:{} with lines title 'actual'\n",
          column, column + 1);
    }
  }
  return script + "unset multiplot\n";
}

}  // namespace

tl::expected<void, std::string> write_jitter_csv(const ecat_master::CycleStatistics& statistics,
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
  return write_file(file, text);
}

tl::expected<std::map<std::string, std::filesystem::path>, std::string> draw_plots(
    const std::filesystem::path& directory, const std::vector<AxisReport>& axes) {
  const auto script_file = directory / "plots.gp";
  auto script = jitter_script();
  std::map<std::string, std::filesystem::path> pictures{{"jitter_plot", directory / "jitter.png"}};
  if (!axes.empty()) {
    script += axes_script(axes, "positions.png", "commanded and actual position", false) +
              axes_script(axes, "following_error.png", "following error", true);
    pictures["position_plot"] = directory / "positions.png";
    pictures["following_error_plot"] = directory / "following_error.png";
  }
  if (auto written = write_file(script_file, script); !written) return tl::unexpected(written.error());
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
  if (auto written = write_file(directory / "clocks.gp", script + '\n'); !written)
    return tl::unexpected(written.error());
  if (auto drawn = run_gnuplot(directory, "clocks.gp"); !drawn) return tl::unexpected(drawn.error());
  return directory / "clocks.png";
}

}  // namespace driveline::cli
