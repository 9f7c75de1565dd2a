#include "text/load_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "driveline/runtime/files/output_file.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {
namespace {

using runtime::LoadEstimate;
using runtime::LoadFigure;

/// A figure and its key in a line description.
struct Figure {
  std::string_view key;
  std::string_view unit;
  LoadFigure load;
  bool negative = false;  ///< it may be below 0
};

std::vector<Figure> figures_of(const LoadEstimate& load, const motion::AxisConfig& axis) {
  const bool linear = axis.linear();
  std::vector<Figure> figures{
      {"inertia", linear ? "kg" : "kg m²", load.inertia},
      {"viscous_friction", linear ? "N s/m" : "Nm s/rad", load.viscous_friction},
      {"coulomb_friction", linear ? "N" : "Nm", load.coulomb_friction},
      {"gravity", linear ? "N" : "Nm", load.gravity, true},
  };
  if (!load.pendulum || !load.pendulum_zero) return figures;
  const auto& unit = motion::position_unit(axis);
  figures.push_back({"pendulum", "Nm", *load.pendulum});
  figures.push_back({"pendulum_zero",
                     unit.name,
                     {unit.from_si(load.pendulum_zero->value), unit.from_si(load.pendulum_zero->interval)},
                     true});
  return figures;
}

/// The value for the description: a friction below 0 becomes 0.
double for_the_key(const Figure& figure) {
  return figure.negative ? figure.load.value : std::max(figure.load.value, 0.0);
}

}  // namespace

std::string load_text(const LoadEstimate& load, const motion::AxisConfig& axis) {
  const auto figures = figures_of(load, axis);
  const std::string_view torque = axis.linear() ? "N" : "Nm";
  auto text = fmt::format("load of axis {}, each figure with its 95 % confidence interval\n\n", axis.name);
  for (const auto& figure : figures) {
    text += fmt::format("  {:<18}{:>13.5g} +- {:<10.2g} {}\n", figure.key, figure.load.value, figure.load.interval,
                        figure.unit);
  }
  text += fmt::format("\n  torque measured    {:>13.5g} {} RMS\n  without the model  {:>13.5g} {} RMS, {:.1f} %\n",
                      load.torque_rms, torque, load.residual_rms, torque, 100.0 * load.residual_rms / load.torque_rms);
  text += fmt::format("  condition          {:>13.3g}, {} windows\n\nfor the [[axis]] of the line description:\n\n",
                      load.condition, load.rows.size());
  for (const auto& figure : figures) text += fmt::format("{} = {:.4g}\n", figure.key, for_the_key(figure));
  return text;
}

nlohmann::json to_json(const LoadEstimate& load, const motion::AxisConfig& axis,
                       const std::map<std::string, std::filesystem::path>& files) {
  nlohmann::json document = {{"axis", axis.name},
                             {"torque_rms", load.torque_rms},
                             {"residual_rms", load.residual_rms},
                             {"condition", load.condition},
                             {"windows", load.rows.size()},
                             {"load", nlohmann::json::object()},
                             {"files", nlohmann::json::object()}};
  for (const auto& figure : figures_of(load, axis)) {
    document["load"][std::string(figure.key)] = {
        {"value", figure.load.value}, {"interval", figure.load.interval}, {"unit", figure.unit}};
  }
  for (const auto& [key, path] : files) document["files"][key] = path.string();
  return document;
}

runtime::Result<void> write_load_csv(const LoadEstimate& load, const motion::AxisConfig& axis,
                                     const std::filesystem::path& file) {
  const auto& unit = motion::position_unit(axis);
  const std::string_view torque = axis.linear() ? "N" : "Nm";
  auto text = fmt::format("time[s],position[{0}],velocity[{0}/s],acceleration[{0}/s^2],torque[{1}],model[{1}]\n",
                          unit.name, torque);
  for (const auto& row : load.rows) {
    text += fmt::format("{:.6f},{:.7g},{:.6g},{:.6g},{:.5g},{:.5g}\n", row.time_s, unit.from_si(row.position),
                        unit.from_si(row.velocity), unit.from_si(row.acceleration), row.torque, row.model);
  }
  return runtime::write_file(file, text);
}

tl::expected<Drawing, std::string> draw_load(const std::filesystem::path& directory, const motion::AxisConfig& axis) {
  // Draw the measurement over a wide pale band of the model, so that both stay visible where they are equal.
  const auto script = fmt::format(
      "set terminal pngcairo size 1400,800 font 'sans,11' noenhanced\n"
      "set output 'load.png'\nset datafile separator ','\nset grid\nset key above\n"
      "set multiplot layout 2,1 title {0}\nset lmargin 11\nset xlabel 'time in s'\nset ylabel '{1} in {2}'\n"
      "plot 'load.csv' skip 1 using 1:6 with points pt 7 ps 1.2 lc rgb '#9ecae1' title 'model', "
      "'' skip 1 using 1:5 with points pt 7 ps 0.4 lc rgb '#08306b' title 'measured'\n"
      "set ylabel 'difference in 1e-3 {2}'\n"
      "plot 'load.csv' skip 1 using 1:(($5-$6)*1e3) with impulses title 'measured minus model'\n"
      "unset multiplot\n",
      gnuplot_text(fmt::format("load of axis {}", axis.name)), axis.linear() ? "force" : "torque",
      axis.linear() ? "N" : "Nm");
  return draw(directory, "load.gp", script, {{"load_plot", "load.png"}});
}

}  // namespace driveline::cli
