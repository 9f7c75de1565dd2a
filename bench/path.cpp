// Motion along geometric paths: the speed of the look-ahead, the cost of the cycle's part, and by how much a motion
// exceeds the minimum duration.
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "driveline/trajectory/delta_kinematics.hpp"
#include "driveline/trajectory/scara_kinematics.hpp"
#include "support/options.hpp"
#include "support/path_optimum.hpp"
#include "support/reference_paths.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline::bench;
using namespace driveline::trajectory;

ContourSettings settings_of(std::size_t axes) {
  ContourSettings settings;
  settings.axes = axes;
  for (std::size_t i = 0; i < axes; ++i) settings.limits[i] = {1.0, 10.0, 1000.0};
  return settings;
}

void must(const tl::expected<void, PathMoveError>& added) {
  if (!added) throw std::runtime_error(added.error().reason);
}

/// A million segments of 0.1 mm on three axes; the follower, which is not measured, makes room in between.
void measure_look_ahead(Report& report, const Options& options) {
  constexpr int kFull = 1'000'000;
  constexpr int kBlock = 500;
  constexpr double kSegment = 1e-4;
  const auto settings = settings_of(3);
  ContourTrack track(settings, {});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  std::vector<double> costs;
  double along = 0.0;
  for (int done = 0; done < options.count(kFull); done += kBlock) {
    std::vector<PathMove> moves;
    for (int k = 0; k < kBlock; ++k) {
      along += kSegment;
      moves.push_back(line_to({0.05 * std::sin(along / 0.05), 0.02 * std::cos(along / 0.03), 0.5 * along}, 5e-6));
    }
    while (!planner.flush()) {
      for (int cycle = 0; cycle < 1000; ++cycle) follower.step();
    }
    const double begin = now_ns();
    for (const auto& move : moves) must(planner.add(move));
    planner.flush();
    costs.push_back((now_ns() - begin) / kBlock);
  }
  constexpr double kAim = 1000.0;  // a million segments per second
  report.add({"short_segments_3_axes", "cost_per_segment", "ns", summarize(std::move(costs)), kAim});
}

/// A machine with kinematics that visits positions in a closed round.
struct Machine {
  std::string name;
  const Kinematics& kinematics;
  GroupAxisLimits joints;
  double tool_velocity;
  std::vector<PathMove> round;  ///< ends at its start
};

/// The cost of the cycle's part with the inverse kinematics, and of a move in the planner.
void measure_machine(Report& report, const Options& options, const Machine& machine) {
  ContourSettings settings;
  settings.axes = machine.kinematics.joints().size();
  settings.kinematics = &machine.kinematics;
  settings.tool.max_velocity = machine.tool_velocity;
  for (std::size_t i = 0; i < settings.axes; ++i) settings.limits[i] = machine.joints;
  ContourTrack track(settings, machine.round.back().target);
  ContourPlanner planner(track);
  ContourFollower follower(track);
  std::vector<double> costs;
  std::vector<double> planning;
  const double reading = reading_cost_ns();
  const int count = options.count(200'000);
  std::size_t next = 0;
  for (int cycle = 0; cycle < count; ++cycle) {
    while (cycle % 64 == 0 && planner.flush()) {
      const auto& move = machine.round[next++ % machine.round.size()];
      const double begin = now_ns();
      must(planner.add(move));
      planning.push_back(now_ns() - begin);
    }
    const double begin = now_ns();
    const auto setpoint = follower.step();
    const double cost = std::max(0.0, now_ns() - begin - reading);
    keep(setpoint);
    if (!setpoint.at_rest) costs.push_back(cost);
  }
  constexpr double kAim = 2000.0;
  report.add({"cycle_" + machine.name, "cost_per_cycle", "ns", summarize(std::move(costs)), kAim, {}, kAim});
  report.add({"moves_of_a_" + machine.name, "cost_per_move", "ns", summarize(std::move(planning))});
}

/// Pick-and-place motions of a delta and a SCARA robot.
void measure_machines(Report& report, const Options& options) {
  constexpr double kTolerance = 0.015;
  const RotaryDeltaKinematics delta({0.2, 0.045, 0.25, 0.6});
  measure_machine(report, options,
                  {"delta",
                   delta,
                   {15.0, 400.0, 40'000.0},
                   6.0,
                   {line_to({-0.15, 0.0, -0.62}, 0.0), line_to({-0.15, 0.0, -0.58}, kTolerance),
                    line_to({0.15, 0.0, -0.58}, kTolerance), line_to({0.15, 0.0, -0.62}, 0.0),
                    line_to({0.15, 0.0, -0.58}, kTolerance), line_to({-0.15, 0.0, -0.58}, kTolerance)}});
  const ScaraKinematics scara({0.35, 0.25, true});
  measure_machine(report, options,
                  {"scara",
                   scara,
                   {10.0, 100.0, 10'000.0},
                   4.0,
                   {line_to({0.4, -0.15, -0.1, 0.0}, 0.0), line_to({0.4, -0.15, 0.0, 0.0}, kTolerance),
                    line_to({0.35, 0.2, 0.0, 0.5}, kTolerance), line_to({0.35, 0.2, -0.1, 0.5}, 0.0),
                    line_to({0.35, 0.2, 0.0, 0.5}, kTolerance), line_to({0.4, -0.15, 0.0, 0.0}, kTolerance)}});
}

/// A path of a group of six axes with lines, arcs and blends, while an operator keeps changing the override.
void measure_cycle(Report& report, const Options& options) {
  const auto settings = settings_of(6);
  ContourTrack track(settings, {});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  std::mt19937_64 random(1);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same path in every run
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  std::vector<double> costs;
  GroupVector at{};
  const double reading = reading_cost_ns();
  const int count = options.count(400'000);
  for (int cycle = 0; cycle < count; ++cycle) {
    while (cycle % 64 == 0 && planner.flush()) {
      GroupVector to = at;
      for (std::size_t i = 0; i < settings.axes; ++i) to[i] = place(random);
      if (planner.add(line_to(to, 1e-3))) at = to;
    }
    if (cycle % 5000 == 0) follower.hold(cycle % 10'000 == 0);
    if (cycle % 777 == 0 && !follower.set_override(0.3 + (cycle % 1700) * 1e-3)) throw std::logic_error("override");
    const double begin = now_ns();
    const auto setpoint = follower.step();
    const double cost = std::max(0.0, now_ns() - begin - reading);
    keep(setpoint);
    // A held group has less to do.
    if (!setpoint.at_rest) costs.push_back(cost);
  }
  constexpr double kAim = 2000.0;
  report.add({"cycle_6_axes", "cost_per_cycle", "ns", summarize(std::move(costs)), kAim, {}, kAim});
}

double planned_duration_s(const ReferencePath& path, const ContourSettings& settings) {
  ContourTrack track(settings, path.start);
  ContourPlanner planner(track);
  ContourFollower follower(track);
  for (const auto& move : path.moves) {
    must(planner.add(move));
    if (!planner.flush()) throw std::logic_error("a reference path needs more memory");
  }
  planner.finish();
  planner.flush();
  std::size_t cycles = 1;
  while (!follower.step().at_end || cycles < 2) ++cycles;
  return static_cast<double>(cycles) * settings.period_s;
}

std::vector<ShapedPiece> shaped(const ReferencePath& path, std::size_t axes) {
  PathShaper shaper(axes, path.start);
  std::vector<ShapedPiece> pieces;
  for (const auto& move : path.moves) must(shaper.add(move, pieces));
  shaper.finish(pieces);
  return pieces;
}

double percent_above(double duration_s, double other_s) {
  return 100.0 * (duration_s / other_s - 1.0);
}

/// How good is the numeric optimum? On straight lines the minimum duration is known: T = acceleration / jerk.
void judge_optimum(Report& report, const ContourSettings& settings) {
  const auto& [velocity, acceleration, jerk, lowest, highest] = settings.limits[0];
  const double rise_s = acceleration / jerk;
  std::vector<double> above;
  for (const double length : {0.001, 0.01, 0.1, 0.3}) {
    const double top = acceleration * (std::sqrt(rise_s * rise_s + 4.0 * length / acceleration) - rise_s) / 2.0;
    const double least_s = top >= velocity                ? length / velocity + velocity / acceleration + rise_s
                           : top >= acceleration * rise_s ? 2.0 * (top / acceleration + rise_s)
                                                          : 4.0 * std::cbrt(length / (2.0 * jerk));
    const auto pieces = shaped({"line", {}, {line_to({length}, 0.0)}}, settings.axes);
    above.push_back(percent_above(path_optimum(pieces, settings).achieved_s, least_s));
  }
  report.add({"straight_lines", "optimum_above_least_duration", "%", summarize(std::move(above))});
}

void measure_durations(Report& report, const Options& options) {
  constexpr double kAim = 5.0;
  constexpr double kMilliseconds = 1e3;
  const auto settings = settings_of(3);
  judge_optimum(report, settings);
  std::vector<double> longer;
  std::vector<double> finer;
  std::vector<double> brackets;
  const auto one = [](double value) { return summarize(std::vector<double>{value}); };
  for (const auto& path : reference_paths()) {
    const auto pieces = shaped(path, settings.axes);
    const auto optimum = path_optimum(pieces, settings);
    const double planned_s = planned_duration_s(path, settings);
    longer.push_back(percent_above(planned_s, optimum.achieved_s));
    brackets.push_back(percent_above(optimum.achieved_s, optimum.bound_s));
    if (!options.quick)
      finer.push_back(std::abs(percent_above(path_optimum(pieces, settings, 2).achieved_s, optimum.achieved_s)));
    report.add({path.name, "planned", "ms", one(planned_s * kMilliseconds)});
    report.add({path.name, "optimum", "ms", one(optimum.achieved_s * kMilliseconds)});
    report.add({path.name, "bound_without_jerk", "ms", one(optimum.bound_s * kMilliseconds)});
    report.add({path.name, "longer_than_optimum", "%", one(longer.back()), kAim});
  }
  report.add({"twenty_reference_paths", "longer_than_optimum", "%", summarize(std::move(longer)), kAim});
  report.add({"twenty_reference_paths", "optimum_above_bound", "%", summarize(std::move(brackets))});
  if (!options.quick) report.add({"twenty_reference_paths", "finer_off_optimum", "%", summarize(std::move(finer))});
}

void measure_all(const Options& options) {
  Report report("path");
  measure_look_ahead(report, options);
  measure_cycle(report, options);
  measure_machines(report, options);
  measure_durations(report, options);
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "Paths of groups: look-ahead, the cycle's part, duration?", measure_all);
}
