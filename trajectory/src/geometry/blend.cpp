#include "blend.hpp"

#include <algorithm>
#include <cmath>

#include "group_math.hpp"

namespace driveline::trajectory {
namespace {

/// A smaller turn is not a corner: at 10 m/s it is a velocity step of 10 nm/s.
constexpr double kSmoothTurn = 1e-9;
/// A smaller change of curvature, 1/m, is not a corner.
constexpr double kSmoothBend = 1e-7;
/// Sine of half of 175 degrees. With a sharper turn the path turns back.
constexpr double kSharpestHalfTurn = 0.999048;
/// Shortest blend, m or rad: a shorter one is within the rounding of positions.
constexpr double kShortestCut = 1e-8;

/// Corner of two straight lines with the directions t0 and t1. With b(u) = 2 u^3 - u^4 the blend is
///   corner + cut * (b(u) * t1 - b(1 - u) * t0).
/// b' and b'' are zero at u = 0, and b'' is zero at u = 1: there is no curvature where the lines start. Its distance
/// from the corner is smallest at u = 1/2, where b = 3/16; by symmetry that is the largest deviation from the path,
///   cut * 3/16 * |t1 - t0| = cut * 3/8 * sin(turn / 2).
PathPolynomial line_corner(const GroupVector& corner, const GroupVector& t0, const GroupVector& t1,
                           double cut) noexcept {
  // b(1 - u) = 1 - 2 u + 2 u^3 - u^4
  PathPolynomial c{};
  c[0] = sum(corner, t0, -cut);
  c[1] = times(t0, 2.0 * cut);
  c[3] = times(difference(t1, t0), 2.0 * cut);
  c[4] = times(difference(t1, t0), -cut);
  return c;
}

/// The fifth-degree polynomial that starts and ends like two pieces, with `length` as its length if it were straight.
PathPolynomial joining(const PathGeometry& begin, const PathGeometry& end, double length) noexcept {
  PathPolynomial c{};
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    const double first0 = begin.first[i] * length;
    const double second0 = begin.second[i] * length * length;
    const double way = end.position[i] - begin.position[i] - first0 - second0 / 2.0;
    const double slope = end.first[i] * length - first0 - second0;
    const double bend = end.second[i] * length * length - second0;
    c[0][i] = begin.position[i];
    c[1][i] = first0;
    c[2][i] = second0 / 2.0;
    c[3][i] = 10.0 * way - 4.0 * slope + bend / 2.0;
    c[4][i] = -15.0 * way + 7.0 * slope - bend;
    c[5][i] = 6.0 * way - 3.0 * slope + bend / 2.0;
  }
  return c;
}

GroupVector place_on(const PathPolynomial& c, double u) noexcept {
  GroupVector place = c[5];
  for (std::size_t power = 5; power-- > 0;) place = sum(c[power], place, u);
  return place;
}

/// Upper bound of the distance from the pieces: the largest distance to the point of equal length on them.
double deviation(const PathPolynomial& c, const PathPiece& before, const PathPiece& behind, double cut) noexcept {
  constexpr int kSamples = 32;
  double largest = 0.0;
  for (int k = 1; k < kSamples; ++k) {
    const double u = static_cast<double>(k) / kSamples;
    const double along = cut * (2.0 * u - 1.0);
    const auto there = along < 0.0 ? before.at(before.length() + along) : behind.at(along);
    largest = std::max(largest, norm(difference(place_on(c, u), there.position)));
  }
  constexpr double kBetweenSamples = 1.01;
  return largest * kBetweenSamples;
}

tl::unexpected<PathMoveError> no_room() {
  return tl::unexpected(PathMoveError{"the corner before it cannot be rounded: the moves are too short for a blend"});
}

tl::expected<Blend, PathMoveError> corner_of_lines(const Joint& joint, double tolerance, double longest_cut) {
  Blend out;
  out.cut = std::min(longest_cut, tolerance / (0.375 * joint.half_turn));
  if (out.cut < kShortestCut) return no_room();
  const auto curve = line_corner(joint.behind.position, joint.before.first, joint.behind.first, out.cut);
  // In the middle the speed is lower by the cosine of half the turn; for flat corners the difference is negligible.
  constexpr double kFlat = 0.99 * PathPiece::kLengthError;
  if (joint.half_turn * joint.half_turn / 2.0 <= kFlat) {
    out.pieces.push_back(PathPiece::flat_corner(curve, 2.0 * out.cut));
  } else {
    out.pieces = PathPiece::curve(curve);
  }
  if (out.pieces.empty()) return no_room();
  return out;
}

tl::expected<Blend, PathMoveError> corner_of_curves(const PathPiece& before, const PathPiece& behind, double tolerance,
                                                    double longest_cut) {
  constexpr double kShorter = 0.8;
  double cut = longest_cut;
  while (cut >= kShortestCut) {
    const auto curve = joining(before.at(before.length() - cut), behind.at(cut), 2.0 * cut);
    if (deviation(curve, before, behind, cut) <= tolerance) {
      auto pieces = PathPiece::curve(curve);
      if (!pieces.empty()) return Blend{cut, std::move(pieces)};
    }
    cut *= kShorter;
  }
  return no_room();
}

}  // namespace

Joint joint_of(const PathPiece& before, const PathPiece& behind) noexcept {
  Joint joint{before.at(before.length()), behind.at(0.0)};
  joint.half_turn = 0.5 * norm(difference(joint.behind.first, joint.before.first));
  joint.is_smooth =
      2.0 * joint.half_turn <= kSmoothTurn && norm(difference(joint.behind.second, joint.before.second)) <= kSmoothBend;
  return joint;
}

tl::expected<Blend, PathMoveError> blend(const PathPiece& before, const PathPiece& behind, const Joint& joint,
                                         double tolerance, double longest_cut) {
  if (joint.half_turn > kSharpestHalfTurn) {
    return tl::unexpected(PathMoveError{
        "the path reverses where the move starts, and such a corner cannot be rounded; a tolerance of 0 stops there"});
  }
  if (before.is_line() && behind.is_line()) return corner_of_lines(joint, tolerance, longest_cut);
  return corner_of_curves(before, behind, tolerance, longest_cut);
}

}  // namespace driveline::trajectory
