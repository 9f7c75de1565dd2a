// Motion along geometric paths: how fast is the look-ahead, what does the cycle's part take, and how much longer than
// necessary is a motion?
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "driveline/trajectory/delta_kinematics.hpp"
#include "support/options.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline::bench;
using namespace driveline::trajectory;

constexpr double kFast = 1e9;

ContourSettings settings_of(std::size_t axes) {
  ContourSettings settings;
  settings.axes = axes;
  for (std::size_t i = 0; i < axes; ++i) settings.limits[i] = {1.0, 10.0, 1000.0};
  return settings;
}

PathMove line_to(const GroupVector& target, double tolerance) {
  PathMove move;
  move.target = target;
  move.feed = kFast;
  move.tolerance = tolerance;
  return move;
}

PathMove arc_to(const GroupVector& target, double center_x, double center_y, double tolerance) {
  PathMove move = line_to(target, tolerance);
  move.kind = PathMove::Kind::kArc;
  move.center[0] = center_x;
  move.center[1] = center_y;
  return move;
}

void must(const tl::expected<void, PathMoveError>& added) {
  if (!added) throw std::runtime_error(added.error().reason);
}

/// A million segments of 0.1 mm on three axes; the follower makes room in between, and is not measured.
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
  constexpr double kAim = 1000.0;  // a million segments in a second
  report.add({"short_segments_3_axes", "cost_per_segment", "ns", summarize(std::move(costs)), kAim});
}

/// Picks and places of a delta: the cycle's part with the inverse of its kinematics, and what a move costs the planner.
void measure_delta(Report& report, const Options& options) {
  const RotaryDeltaKinematics delta({0.2, 0.045, 0.25, 0.6});
  ContourSettings settings;
  settings.axes = 3;
  settings.kinematics = &delta;
  settings.tool.max_velocity = 6.0;
  for (std::size_t i = 0; i < settings.axes; ++i) settings.limits[i] = {15.0, 400.0, 40'000.0};
  ContourTrack track(settings, {0.0, 0.0, -0.56});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  constexpr double kTolerance = 0.015;
  const std::vector<GroupVector> places{{-0.15, 0.0, -0.62}, {-0.15, 0.0, -0.58}, {0.15, 0.0, -0.58},
                                        {0.15, 0.0, -0.62},  {0.15, 0.0, -0.58},  {-0.15, 0.0, -0.58}};
  std::vector<double> costs;
  std::vector<double> planning;
  const double reading = reading_cost_ns();
  const int count = options.count(200'000);
  std::size_t next = 0;
  for (int cycle = 0; cycle < count; ++cycle) {
    while (cycle % 64 == 0 && planner.flush()) {
      const auto& to = places[next++ % places.size()];
      const double begin = now_ns();
      must(planner.add(line_to(to, to[2] < -0.6 ? 0.0 : kTolerance)));
      planning.push_back(now_ns() - begin);
    }
    const double begin = now_ns();
    const auto setpoint = follower.step();
    const double cost = std::max(0.0, now_ns() - begin - reading);
    keep(setpoint);
    if (!setpoint.at_rest) costs.push_back(cost);
  }
  constexpr double kAim = 2000.0;
  report.add({"cycle_delta", "cost_per_cycle", "ns", summarize(std::move(costs)), kAim, {}, kAim});
  report.add({"moves_of_a_delta", "cost_per_move", "ns", summarize(std::move(planning))});
}

/// A path of a group of six with lines, arcs and blends, and an operator who does not let go of the knobs.
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
    // A group that is held has less to do.
    if (!setpoint.at_rest) costs.push_back(cost);
  }
  constexpr double kAim = 2000.0;
  report.add({"cycle_6_axes", "cost_per_cycle", "ns", summarize(std::move(costs)), kAim, {}, kAim});
}

struct Reference {
  std::string name;
  GroupVector start{};
  std::vector<PathMove> moves;
};

Reference polygon(int corners, double side, double tolerance) {
  Reference path{fmt::format("polygon of {} corners", corners), {}, {}};
  GroupVector at{};
  for (int k = 0; k < corners; ++k) {
    const double heading = 2.0 * std::numbers::pi * k / corners;
    at[0] += side * std::cos(heading);
    at[1] += side * std::sin(heading);
    path.moves.push_back(line_to(at, tolerance));
  }
  return path;
}

Reference zigzag(double step, double tolerance) {
  Reference path{fmt::format("zigzag with {} mm", tolerance * 1e3), {}, {}};
  for (int k = 1; k <= 10; ++k) path.moves.push_back(line_to({step * k, k % 2 == 0 ? 0.0 : 2.0 * step}, tolerance));
  return path;
}

Reference circles(double radius, double rise) {
  Reference path{fmt::format("circles of {} mm", radius * 1e3), {radius}, {}};
  for (int k = 1; k <= 3; ++k) path.moves.push_back(arc_to({radius, 0.0, rise * k}, 0.0, 0.0, 0.0));
  return path;
}

Reference pocket(double size, double radius) {
  Reference path{"pocket", {radius}, {}};
  const double s = size - radius;
  const double tolerance = 2e-4;
  path.moves = {line_to({s}, tolerance),
                arc_to({size, radius}, s, radius, tolerance),
                line_to({size, s}, tolerance),
                arc_to({s, size}, s, s, tolerance),
                line_to({radius, size}, tolerance),
                arc_to({0.0, s}, radius, s, tolerance),
                line_to({0.0, radius}, tolerance),
                arc_to({radius}, radius, radius, tolerance)};
  return path;
}

Reference spline(std::mt19937_64& random) {
  std::uniform_real_distribution<double> step(0.1, 0.2);
  std::uniform_real_distribution<double> side(-0.1, 0.1);
  PathMove move = line_to({}, 0.0);
  move.kind = PathMove::Kind::kSpline;
  GroupVector at{};
  for (int k = 0; k < 10; ++k) {
    at = {at[0] + step(random), side(random), side(random)};
    move.points.push_back(at);
  }
  return {"spline", {}, {move}};
}

Reference polyline(std::mt19937_64& random, double tolerance) {
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  Reference path{fmt::format("random lines with {} mm", tolerance * 1e3), {}, {}};
  for (int k = 0; k < 8; ++k) path.moves.push_back(line_to({place(random), place(random), place(random)}, tolerance));
  return path;
}

std::vector<Reference> references() {
  std::mt19937_64 random(3);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same paths in every run
  std::vector<Reference> paths{polygon(3, 0.4, 1e-3),  polygon(4, 0.4, 1e-3), polygon(6, 0.3, 1e-3),
                               polygon(12, 0.2, 1e-3), zigzag(0.1, 2e-4),     zigzag(0.1, 1e-3),
                               zigzag(0.1, 5e-3),      circles(0.1, 0.0),     circles(0.3, 0.0),
                               circles(0.1, 0.05),     pocket(0.3, 0.05),     pocket(0.4, 0.02)};
  for (int k = 0; k < 3; ++k) paths.push_back(spline(random));
  for (const double tolerance : {1e-4, 5e-4, 1e-3, 2e-3, 5e-3}) paths.push_back(polyline(random, tolerance));
  return paths;
}

/// The geometry of a path on a fine grid.
struct Grid {
  std::vector<PathGeometry> points;
  std::vector<double> steps;  ///< to the next point
  std::vector<bool> stops;
};

Grid grid_of(const Reference& path, std::size_t axes) {
  PathShaper shaper(axes, path.start);
  std::vector<ShapedPiece> pieces;
  for (const auto& move : path.moves) must(shaper.add(move, pieces));
  shaper.finish(pieces);
  Grid grid;
  for (const auto& shaped : pieces) {
    const double length = shaped.piece.length();
    const int count = static_cast<int>(std::clamp(length / 2e-5, 60.0, 20'000.0));
    for (int k = 0; k < count; ++k) {
      // Both ends of a piece are looked at from within: curvatures that jump are on the right side.
      grid.points.push_back(shaped.piece.at(length * (k + 0.5) / count));
      grid.steps.push_back(length / count);
      grid.stops.push_back(shaped.stops && k + 1 == count);
    }
  }
  return grid;
}

/// The range of accelerations along the path at the square of a speed; empty (low > high) where the speed is too high.
std::pair<double, double> range_at(const PathGeometry& point, double speed2, const ContourSettings& settings) {
  std::pair<double, double> range{-1e12, 1e12};
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    const double f = point.first[i];
    const double bend = point.second[i] * speed2;
    if (f * f * speed2 > limits.max_velocity * limits.max_velocity * (1.0 + 1e-12)) return {1.0, -1.0};
    if (std::abs(f) < 1e-12) {
      if (std::abs(bend) > limits.max_acceleration) return {1.0, -1.0};
      continue;
    }
    const double one = (limits.max_acceleration - bend) / f;
    const double other = (-limits.max_acceleration - bend) / f;
    range = {std::max(range.first, std::min(one, other)), std::min(range.second, std::max(one, other))};
  }
  return range;
}

/// The shortest duration that the limits of velocity and acceleration allow (jerk without limit), which nothing can be
/// below: backwards, the highest speed from which the rest can be done; forwards, as fast as this allows.
double shortest_duration_s(const Grid& grid, const ContourSettings& settings) {
  constexpr int kBisections = 45;
  const std::size_t n = grid.points.size();
  std::vector<double> most2(n + 1, 0.0);
  for (std::size_t k = n; k-- > 0;) {
    const double next2 = grid.stops[k] ? 0.0 : most2[k + 1];
    double low = 0.0;
    double high = 100.0;
    for (int round = 0; round < kBisections; ++round) {
      const double middle = 0.5 * (low + high);
      const auto [hardest, softest] = range_at(grid.points[k], middle, settings);
      const bool can = hardest <= softest && middle + 2.0 * hardest * grid.steps[k] <= next2;
      (can ? low : high) = middle;
    }
    most2[k] = low;
  }
  double duration_s = 0.0;
  double speed2 = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const double end2 = grid.stops[k] ? 0.0 : most2[k + 1];
    const double next2 =
        std::clamp(speed2 + 2.0 * range_at(grid.points[k], speed2, settings).second * grid.steps[k], 0.0, end2);
    duration_s += 2.0 * grid.steps[k] / (std::sqrt(speed2) + std::sqrt(next2));
    speed2 = next2;
  }
  return duration_s;
}

double planned_duration_s(const Reference& path, const ContourSettings& settings) {
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

void measure_durations(Report& report) {
  const auto settings = settings_of(3);
  std::vector<double> ratios;
  for (const auto& path : references()) {
    const double shortest_s = shortest_duration_s(grid_of(path, settings.axes), settings);
    const double planned_s = planned_duration_s(path, settings);
    ratios.push_back(planned_s / shortest_s);
    report.note(
        fmt::format("{}: {:.3f} s, at least {:.3f} s, {:.3f}", path.name, planned_s, shortest_s, ratios.back()));
  }
  constexpr double kAim = 1.05;
  report.add({"twenty_reference_paths", "duration_by_bound", "1", summarize(std::move(ratios)), kAim});
}

void measure_all(const Options& options) {
  Report report("path");
  measure_look_ahead(report, options);
  measure_cycle(report, options);
  measure_delta(report, options);
  measure_durations(report);
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "Paths of groups: look-ahead, the cycle's part, duration?", measure_all);
}
