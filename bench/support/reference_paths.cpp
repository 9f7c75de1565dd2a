#include "support/reference_paths.hpp"

#include <fmt/format.h>
#include <cmath>
#include <numbers>
#include <random>

namespace driveline::bench {

using trajectory::GroupVector;
using trajectory::PathMove;

PathMove line_to(const GroupVector& target, double tolerance) {
  PathMove move;
  move.target = target;
  constexpr double kFast = 1e9;
  move.feed = kFast;
  move.tolerance = tolerance;
  return move;
}

namespace {

PathMove arc_to(const GroupVector& target, double center_x, double center_y, double tolerance) {
  PathMove move = line_to(target, tolerance);
  move.kind = PathMove::Kind::kArc;
  move.center[0] = center_x;
  move.center[1] = center_y;
  return move;
}

ReferencePath polygon(int corners, double side, double tolerance) {
  ReferencePath path{fmt::format("polygon_of_{}_corners", corners), {}, {}};
  GroupVector at{};
  for (int k = 0; k < corners; ++k) {
    const double heading = 2.0 * std::numbers::pi * k / corners;
    at[0] += side * std::cos(heading);
    at[1] += side * std::sin(heading);
    path.moves.push_back(line_to(at, tolerance));
  }
  return path;
}

ReferencePath zigzag(double step, double tolerance) {
  ReferencePath path{fmt::format("zigzag_within_{}_mm", tolerance * 1e3), {}, {}};
  for (int k = 1; k <= 10; ++k) path.moves.push_back(line_to({step * k, k % 2 == 0 ? 0.0 : 2.0 * step}, tolerance));
  return path;
}

ReferencePath circles(double radius, double rise) {
  const auto* const what = rise > 0.0 ? "helix" : "circles";
  ReferencePath path{fmt::format("{}_of_{}_mm", what, radius * 1e3), {radius}, {}};
  for (int k = 1; k <= 3; ++k) path.moves.push_back(arc_to({radius, 0.0, rise * k}, 0.0, 0.0, 0.0));
  return path;
}

ReferencePath pocket(double size, double radius) {
  ReferencePath path{fmt::format("pocket_with_{}_mm", radius * 1e3), {radius}, {}};
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

ReferencePath spline(std::mt19937_64& random, int number) {
  std::uniform_real_distribution<double> step(0.1, 0.2);
  std::uniform_real_distribution<double> side(-0.1, 0.1);
  PathMove move = line_to({}, 0.0);
  move.kind = PathMove::Kind::kSpline;
  GroupVector at{};
  for (int k = 0; k < 10; ++k) {
    at = {at[0] + step(random), side(random), side(random)};
    move.points.push_back(at);
  }
  return {fmt::format("spline_{}", number), {}, {move}};
}

ReferencePath polyline(std::mt19937_64& random, double tolerance) {
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  ReferencePath path{fmt::format("random_lines_within_{}_mm", tolerance * 1e3), {}, {}};
  for (int k = 0; k < 8; ++k) path.moves.push_back(line_to({place(random), place(random), place(random)}, tolerance));
  return path;
}

}  // namespace

std::vector<ReferencePath> reference_paths() {
  std::mt19937_64 random(3);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same paths in every run
  std::vector<ReferencePath> paths{polygon(3, 0.4, 1e-3),  polygon(4, 0.4, 1e-3), polygon(6, 0.3, 1e-3),
                                   polygon(12, 0.2, 1e-3), zigzag(0.1, 2e-4),     zigzag(0.1, 1e-3),
                                   zigzag(0.1, 5e-3),      circles(0.1, 0.0),     circles(0.3, 0.0),
                                   circles(0.1, 0.05),     pocket(0.3, 0.05),     pocket(0.4, 0.02)};
  for (int k = 1; k <= 3; ++k) paths.push_back(spline(random, k));
  for (const double tolerance : {1e-4, 5e-4, 1e-3, 2e-3, 5e-3}) paths.push_back(polyline(random, tolerance));
  return paths;
}

}  // namespace driveline::bench
