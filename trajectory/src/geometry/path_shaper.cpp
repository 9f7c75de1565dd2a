#include "driveline/trajectory/path_shaper.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "arc.hpp"
#include "blend.hpp"
#include "group_math.hpp"
#include "point_spline.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Positions lie within +-1e6 rad or m: there a double resolves 0.1 nm.
constexpr double kFarthest = 1e6;
/// Shorter moves are no motion.
constexpr double kShortestMove = 1e-9;

tl::unexpected<PathMoveError> bad_move(std::string reason) {
  return tl::unexpected(PathMoveError{std::move(reason)});
}

tl::expected<void, PathMoveError> check_place(const GroupVector& place, std::size_t axes, const char* what) {
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    if (i >= axes && place[i] != 0.0) {
      return bad_move(std::string(what) + " has a value for axis " + std::to_string(i + 1) + " of " +
                      std::to_string(axes));
    }
    if (!(std::abs(place[i]) <= kFarthest)) {
      return bad_move(std::string(what) + " of axis " + std::to_string(i + 1) + " is " + to_short_text(place[i]) +
                      "; positions lie within +-1e6 m or rad");
    }
  }
  return {};
}

tl::expected<void, PathMoveError> check_shape(const PathMove& move, std::size_t axes) {
  if (move.kind == PathMove::Kind::kSpline) {
    if (move.points.empty()) return bad_move("a spline needs at least one point");
    for (const auto& point : move.points) {
      if (auto checked = check_place(point, axes, "a point of the spline"); !checked) return checked;
    }
    return {};
  }
  if (auto checked = check_place(move.target, axes, "the target"); !checked) return checked;
  if (move.kind == PathMove::Kind::kArcVia) return check_place(move.via, axes, "the point on the arc");
  if (move.kind != PathMove::Kind::kArc) return {};
  if (move.first_axis >= axes || move.second_axis >= axes || move.first_axis == move.second_axis) {
    return bad_move("an arc around a centre needs two different axes of the group");
  }
  return check_place(move.center, axes, "the centre");
}

tl::expected<void, PathMoveError> check_move(const PathMove& move, std::size_t axes) {
  if (!(move.feed > 0.0)) return bad_move("the feed is " + to_short_text(move.feed) + "; it must be above 0");
  if (!(move.tolerance >= 0.0) || !std::isfinite(move.tolerance)) {
    return bad_move("the tolerance is " + to_short_text(move.tolerance) + "; it must be 0 or more, and finite");
  }
  return check_shape(move, axes);
}

tl::expected<std::vector<PathPiece>, PathMoveError> spline_pieces(const GroupVector& from, const PathMove& move) {
  std::vector<GroupVector> points{from};
  for (const auto& point : move.points) {
    if (norm(difference(point, points.back())) > kShortestMove) points.push_back(point);
  }
  std::vector<PathPiece> pieces;
  if (points.size() < 2) return pieces;
  for (const auto& polynomial : point_spline(points)) {
    auto fitted = PathPiece::curve(polynomial);
    if (fitted.empty()) {
      return bad_move("the spline stands still or turns back between two of its points; more even points help");
    }
    pieces.insert(pieces.end(), fitted.begin(), fitted.end());
  }
  return pieces;
}

}  // namespace

PathShaper::PathShaper(std::size_t axes, const GroupVector& start) : axes_(axes), target_(start) {
  if (axes == 0 || axes > kMaxGroupAxes) throw std::invalid_argument("a group has 1 to 8 axes");
  if (const auto checked = check_place(start, axes, "the first place"); !checked) {
    throw std::invalid_argument(checked.error().reason);
  }
}

tl::expected<std::vector<PathPiece>, PathMoveError> PathShaper::shaped(const PathMove& move) const {
  if (move.kind == PathMove::Kind::kSpline) return spline_pieces(target_, move);
  std::vector<PathPiece> pieces;
  if (move.kind == PathMove::Kind::kLine) {
    if (norm(difference(move.target, target_)) > kShortestMove) pieces.push_back(PathPiece::line(target_, move.target));
    return pieces;
  }
  const auto arc = move.kind == PathMove::Kind::kArc ? arc_around(target_, move) : arc_via(target_, move);
  if (!arc) return tl::unexpected(arc.error());
  pieces.push_back(PathPiece::arc(*arc));
  return pieces;
}

void PathShaper::hand_over(std::vector<ShapedPiece>& out, bool stops) {
  for (const auto& piece : last_) {
    if (piece.length() > 0.0) out.push_back({piece, feed_, last_move_, false});
  }
  if (!last_.empty() && !out.empty()) out.back().stops = stops;
  last_.clear();
}

tl::expected<void, PathMoveError> PathShaper::add(const PathMove& move, std::vector<ShapedPiece>& out) {
  if (auto checked = check_move(move, axes_); !checked) return checked;
  auto pieces = shaped(move);
  if (!pieces) return tl::unexpected(std::move(pieces.error()));
  const auto number = moves_;
  if (pieces->empty()) {
    ++moves_;
    return {};
  }
  const double half = pieces->front().length() / 2.0;
  const double end_half = pieces->back().length() / 2.0;
  bool stops = false;
  Blend corner;
  if (!last_.empty()) {
    const auto joint = joint_of(last_.back(), pieces->front());
    stops = !joint.is_smooth && !(tolerance_ > 0.0);
    if (!joint.is_smooth && !stops) {
      // Half of each piece is left for the corner at its other end.
      auto found = blend(last_.back(), pieces->front(), joint, tolerance_, std::min(last_half_, half));
      if (!found) return tl::unexpected(std::move(found.error()));
      corner = std::move(*found);
      last_.back() = last_.back().part(0.0, last_.back().length() - corner.cut);
      pieces->front() = pieces->front().part(corner.cut, pieces->front().length());
    }
  }
  hand_over(out, stops);
  for (const auto& piece : corner.pieces) out.push_back({piece, std::min(feed_, move.feed), number, false});
  target_ = move.kind == PathMove::Kind::kSpline ? move.points.back() : move.target;
  last_ = std::move(*pieces);
  last_half_ = end_half;
  feed_ = move.feed;
  tolerance_ = move.tolerance;
  last_move_ = number;
  ++moves_;
  return {};
}

void PathShaper::finish(std::vector<ShapedPiece>& out) {
  hand_over(out, true);
}

}  // namespace driveline::trajectory
