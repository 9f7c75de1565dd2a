#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "driveline/trajectory/path_move.hpp"
#include "support.hpp"

namespace driveline::trajectory::test {

/// Random moves, and their paths by elementary formulas, independent of the planner's geometry.
struct MovePlan {
  GroupVector start{};
  std::vector<PathMove> moves;
};

inline double distance(const GroupVector& a, const GroupVector& b) {
  double total = 0.0;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) total += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(total);
}

inline PathMove line_to(const GroupVector& target, double feed, double tolerance) {
  PathMove move;
  move.target = target;
  move.feed = feed;
  move.tolerance = tolerance;
  return move;
}

/// An arc in the plane of the first two axes, by its centre and its angle (negative: clockwise).
inline PathMove arc_by(const GroupVector& from, double center_x, double center_y, double angle_rad, double feed,
                       double tolerance) {
  PathMove move = line_to(from, feed, tolerance);
  move.kind = PathMove::Kind::kArc;
  const double dx = from[0] - center_x;
  const double dy = from[1] - center_y;
  move.target[0] = center_x + dx * std::cos(angle_rad) - dy * std::sin(angle_rad);
  move.target[1] = center_y + dx * std::sin(angle_rad) + dy * std::cos(angle_rad);
  move.center[0] = center_x;
  move.center[1] = center_y;
  move.clockwise = angle_rad < 0.0;
  return move;
}

/// Lines and arcs of `axes` axes; about every third corner is exact.
inline MovePlan random_moves(Random& random, std::size_t axes, std::size_t count, double size) {
  MovePlan plan;
  GroupVector at{};
  for (std::size_t i = 0; i < axes; ++i) at[i] = random.real(-size, size);
  plan.start = at;
  for (std::size_t k = 0; k < count; ++k) {
    const double feed = random.index(0, 2) == 0 ? random.real(0.05, 0.5) : 1e9;
    const double tolerance = random.index(0, 3) == 0 ? 0.0 : random.magnitude(1e-5, 1e-2) * size;
    PathMove move;
    if (axes >= 2 && random.index(0, 3) == 0) {
      const double radius = random.real(0.2, 1.0) * size;
      const double heading = random.real(0.0, 2.0 * std::numbers::pi);
      const double angle = random.real(0.3, 5.5) * (random.index(0, 1) == 0 ? 1.0 : -1.0);
      move = arc_by(at, at[0] + radius * std::cos(heading), at[1] + radius * std::sin(heading), angle, feed, tolerance);
    } else {
      GroupVector to = at;
      for (std::size_t i = 0; i < axes; ++i) {
        if (axes == 1 || random.index(0, 3) != 0) to[i] += random.real(-size, size);
      }
      if (distance(to, at) < 0.05 * size) to[0] += 0.3 * size;
      move = line_to(to, feed, tolerance);
    }
    plan.moves.push_back(move);
    at = move.target;
  }
  return plan;
}

inline double distance_from_line(const GroupVector& p, const GroupVector& a, const GroupVector& b) {
  double along = 0.0;
  double length2 = 0.0;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    along += (p[i] - a[i]) * (b[i] - a[i]);
    length2 += (b[i] - a[i]) * (b[i] - a[i]);
  }
  const double t = length2 > 0.0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
  GroupVector nearest = a;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) nearest[i] += t * (b[i] - a[i]);
  return distance(p, nearest);
}

/// Distance from an arc in the plane of the first two axes.
inline double distance_from_arc(const GroupVector& p, const GroupVector& from, const PathMove& move) {
  const double turn = move.clockwise ? -1.0 : 1.0;
  const auto angle_of = [&](const GroupVector& place) {
    return std::atan2(turn * (place[1] - move.center[1]), place[0] - move.center[0]);
  };
  const auto beyond = [&](double angle) {
    const double difference = std::fmod(angle - angle_of(from) + 4.0 * std::numbers::pi, 2.0 * std::numbers::pi);
    return difference;
  };
  const double ends = std::min(distance(p, from), distance(p, move.target));
  if (beyond(angle_of(p)) > beyond(angle_of(move.target))) return ends;
  const double radius = std::hypot(from[0] - move.center[0], from[1] - move.center[1]);
  double total = std::hypot(p[0] - move.center[0], p[1] - move.center[1]) - radius;
  total *= total;
  for (std::size_t i = 2; i < kMaxGroupAxes; ++i) total += (p[i] - from[i]) * (p[i] - from[i]);
  return std::min(ends, std::sqrt(total));
}

/// Distance from one of the lines and arcs.
inline double distance_from_move(const GroupVector& p, const MovePlan& plan, std::size_t number) {
  const auto& from = number == 0 ? plan.start : plan.moves[number - 1].target;
  const auto& move = plan.moves[number];
  return move.kind == PathMove::Kind::kArc ? distance_from_arc(p, from, move)
                                           : distance_from_line(p, from, move.target);
}

}  // namespace driveline::trajectory::test
