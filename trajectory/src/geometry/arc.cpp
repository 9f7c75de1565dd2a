#include "arc.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "group_math.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
/// Distance, relative to the radius, below which two points are the same.
constexpr double kSamePlace = 1e-9;

tl::unexpected<PathMoveError> bad_arc(std::string reason) {
  return tl::unexpected(PathMoveError{std::move(reason)});
}

tl::expected<CircularArc, PathMoveError> of_allowed_radius(const CircularArc& arc, double tolerance) {
  const double radius = norm(arc.to_start);
  if (tolerance > 0.0 && radius < tolerance) {
    return bad_arc("the radius of the arc, " + to_short_text(radius) + " m, is below the tolerance of " +
                   to_short_text(tolerance) + " m");
  }
  return arc;
}

/// Angle from 0 (exclusive) to a full turn.
double positive_angle(double y, double x) {
  const double angle = std::atan2(y, x);
  return angle > 0.0 ? angle : angle + kTurn;
}

}  // namespace

tl::expected<CircularArc, PathMoveError> arc_around(const GroupVector& from, const PathMove& move) {
  const std::size_t i = move.first_axis;
  const std::size_t j = move.second_axis;
  double center_i = move.center[i];
  double center_j = move.center[j];
  const double radius = std::hypot(from[i] - center_i, from[j] - center_j);
  const double end_radius = std::hypot(move.target[i] - center_i, move.target[j] - center_j);
  const double chord_i = move.target[i] - from[i];
  const double chord_j = move.target[j] - from[j];
  const double chord = std::hypot(chord_i, chord_j);
  if (!(radius > 0.0)) return bad_arc("the arc starts at its own centre");
  const bool whole = chord <= kSamePlace * radius;
  double shift = 0.0;
  if (!whole) {
    // Find the centre with equal distance to both ends that is nearest to the given one.
    shift = ((from[i] + move.target[i]) / 2.0 - center_i) * chord_i / chord +
            ((from[j] + move.target[j]) / 2.0 - center_j) * chord_j / chord;
    center_i += shift * chord_i / chord;
    center_j += shift * chord_j / chord;
  }
  if (std::abs(end_radius - radius) > kArcClosure * radius || std::abs(shift) > kArcClosure * radius) {
    return bad_arc("the arc does not close: it begins " + to_short_text(radius) + " m from its centre and ends " +
                   to_short_text(end_radius) + " m from it");
  }
  CircularArc arc;
  const double turn = move.clockwise ? -1.0 : 1.0;
  arc.to_start[i] = from[i] - center_i;
  arc.to_start[j] = from[j] - center_j;
  arc.across[i] = -turn * arc.to_start[j];
  arc.across[j] = turn * arc.to_start[i];
  arc.center = from;
  arc.center[i] = center_i;
  arc.center[j] = center_j;
  arc.rise = difference(move.target, from);
  arc.rise[i] = 0.0;
  arc.rise[j] = 0.0;
  GroupVector to_end{};
  to_end[i] = move.target[i] - center_i;
  to_end[j] = move.target[j] - center_j;
  arc.angle_rad = whole ? kTurn : positive_angle(dot(to_end, arc.across), dot(to_end, arc.to_start));
  return of_allowed_radius(arc, move.tolerance);
}

tl::expected<CircularArc, PathMoveError> arc_via(const GroupVector& from, const PathMove& move) {
  const GroupVector to_via = difference(move.via, from);
  const GroupVector to_end = difference(move.target, from);
  const double via2 = dot(to_via, to_via);
  const double end2 = dot(to_end, to_end);
  const double product = dot(to_via, to_end);
  const double area = via2 * end2 - product * product;
  constexpr double kFlat = 1e-12;
  if (!(area > kFlat * via2 * end2) || !(via2 * end2 > 0.0)) {
    return bad_arc("the three points of the arc are on a straight line, or two of them are the same");
  }
  CircularArc arc;
  arc.center =
      sum(sum(from, to_via, end2 * (via2 - product) / (2.0 * area)), to_end, via2 * (end2 - product) / (2.0 * area));
  arc.to_start = difference(from, arc.center);
  const double radius = norm(arc.to_start);
  // Second direction of the plane: the guide point (end or via point) without its part along the first direction. If
  // the end comes before the via point, the arc runs the other way round.
  const GroupVector end = difference(move.target, arc.center);
  const GroupVector via = difference(move.via, arc.center);
  const GroupVector& guide = std::abs(dot(end, arc.to_start)) < std::abs(dot(via, arc.to_start)) ? end : via;
  GroupVector across = sum(guide, arc.to_start, -dot(guide, arc.to_start) / (radius * radius));
  arc.across = times(across, radius / norm(across));
  const double via_angle = positive_angle(dot(via, arc.across), dot(via, arc.to_start));
  arc.angle_rad = positive_angle(dot(end, arc.across), dot(end, arc.to_start));
  if (arc.angle_rad < via_angle) {
    arc.across = times(arc.across, -1.0);
    arc.angle_rad = kTurn - arc.angle_rad;
  }
  return of_allowed_radius(arc, move.tolerance);
}

}  // namespace driveline::trajectory
