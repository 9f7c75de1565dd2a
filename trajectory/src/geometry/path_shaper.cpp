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

/// Largest magnitude of a position, rad or m: there a double resolves 0.1 nm.
constexpr double kFarthest = 1e6;
/// Shorter moves count as no motion.
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

tl::expected<void, PathMoveError> check_events(const PathMove& move) {
  if (!(move.dwell_s >= 0.0 && move.dwell_s <= kLongestDwell)) {
    return bad_move("the dwell is " + to_short_text(move.dwell_s) + " s; it must be from 0 to 3600 s");
  }
  for (const auto& output : move.outputs) {
    if (std::isnan(output.at) || !std::isfinite(output.change.value)) {
      return bad_move("an output and its place must be numbers");
    }
  }
  return {};
}

double length_of(const std::vector<PathPiece>& pieces) {
  double length = 0.0;
  for (const auto& piece : pieces) length += piece.length();
  return length;
}

/// The events of a move with their positions along it, in path order.
tl::expected<std::vector<PathEvent>, PathMoveError> events_of(const PathMove& move, double length) {
  std::vector<PathEvent> events;
  for (const auto& [change, at] : move.outputs) {
    const double place = std::isinf(at) ? length : at < 0.0 ? length + at : at;
    constexpr double kLengthTolerance = 1e-9;
    if (!(place >= -kLengthTolerance && place <= length + kLengthTolerance)) {
      return bad_move("an output would change " + to_short_text(std::abs(at)) + " m " +
                      (at < 0.0 ? "before the end" : "after the start") + " of a move that is " +
                      to_short_text(length) + " m long");
    }
    events.push_back({std::clamp(place, 0.0, length), change, 0.0});
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  if (move.dwell_s > 0.0) events.push_back({length, {}, move.dwell_s});
  return events;
}

tl::unexpected<PathMoveError> too_many_events() {
  return bad_move("more than " + std::to_string(kMaxOutputsOfMove) + " outputs and dwells in one move");
}

/// Appends pieces one after the other, with the events on them.
void put_pieces(const std::vector<PathPiece>& pieces, double feed, std::uint64_t move,
                const std::vector<PathEvent>& events, std::vector<ShapedPiece>& out) {
  const auto first = out.size();
  for (const auto& piece : pieces) {
    if (piece.length() > 0.0) out.push_back({piece, feed, move, false, {}});
  }
  std::size_t index = first;
  double begin = 0.0;
  for (auto event : events) {
    while (index + 1 < out.size() && event.at > begin + out[index].piece.length()) {
      begin += out[index].piece.length();
      ++index;
    }
    if (index == out.size()) return;  // no event without a piece
    // The end of the move is the end of its last piece, however the sum of lengths was rounded.
    constexpr double kStartTolerance = 1e-12;
    const double length = out[index].piece.length();
    event.at = std::clamp(event.at - begin, 0.0, length);
    if (event.dwell_s > 0.0 && event.at > kStartTolerance) event.at = length;
    out[index].events.push_back(event);
  }
}

tl::expected<void, PathMoveError> check_move(const PathMove& move, std::size_t axes) {
  if (!(move.feed > 0.0)) return bad_move("the feed is " + to_short_text(move.feed) + "; it must be above 0");
  if (!(move.tolerance >= 0.0) || !std::isfinite(move.tolerance)) {
    return bad_move("the tolerance is " + to_short_text(move.tolerance) + "; it must be 0 or more, and finite");
  }
  if (auto checked = check_events(move); !checked) return checked;
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
      return bad_move("the spline stops or reverses between two of its points; use more evenly spaced points");
    }
    pieces.insert(pieces.end(), fitted.begin(), fitted.end());
  }
  return pieces;
}

}  // namespace

PathShaper::PathShaper(std::size_t axes, const GroupVector& start, const PathCheck* check)
    : axes_(axes), check_(check), target_(start) {
  if (axes == 0 || axes > kMaxGroupAxes) throw std::invalid_argument("a group has 1 to 8 axes");
  if (const auto checked = check_place(start, axes, "the first position"); !checked) {
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

tl::expected<void, PathMoveError> PathShaper::checked(const std::vector<PathPiece>& pieces) const {
  if (check_ == nullptr || !check_->is_needed()) return {};
  for (const auto& piece : pieces) {
    if (auto fault = check_->fault_on(piece); !fault.empty()) return bad_move(std::move(fault));
  }
  return {};
}

void PathShaper::hand_over(std::vector<ShapedPiece>& out, bool stops) {
  if (last_.empty()) return;
  put_pieces(last_, feed_, last_move_, events_, out);
  if (!out.empty()) out.back().stops = stops;
  last_.clear();
  events_.clear();
  dwells_ = false;
}

void PathShaper::add_without_way(const PathMove& move) {
  const double at = length_of(last_);
  for (const auto& output : move.outputs) events_.push_back({at, output.change, 0.0});
  if (move.dwell_s > 0.0) events_.push_back({at, {}, move.dwell_s});
  dwells_ = dwells_ || move.dwell_s > 0.0;
  ++moves_;
}

/// Extracts the events of the stored move and of the next one (`behind`) that lie on the corner between them; the
/// positions of the remaining events of `behind` become relative to its remaining part.
std::vector<PathEvent> PathShaper::take_events_of_corner(double cut, double corner, std::vector<PathEvent>& behind) {
  if (!(cut > 0.0)) return {};
  std::vector<PathEvent> taken;
  const double left = length_of(last_);  // length without the part that was cut off
  const double half = 0.5 * corner;
  while (!events_.empty() && events_.back().at > left) {
    auto event = events_.back();
    event.at = std::min(half, (event.at - left) / cut * half);
    taken.insert(taken.begin(), event);
    events_.pop_back();
  }
  std::vector<PathEvent> rest;
  for (auto event : behind) {
    event.at -= cut;
    if (event.at < 0.0) {
      event.at = half + (event.at + cut) / cut * half;
      taken.push_back(event);
    } else {
      rest.push_back(event);
    }
  }
  behind = std::move(rest);
  return taken;
}

/// Shapes the corner between the stored move and `pieces`, and cuts both for it.
tl::expected<PathShaper::Corner, PathMoveError> PathShaper::join(std::vector<PathPiece>& pieces) {
  Corner corner;
  if (last_.empty()) return corner;
  const auto joint = joint_of(last_.back(), pieces.front());
  corner.stops = dwells_ || (!joint.is_smooth && !(tolerance_ > 0.0));
  if (joint.is_smooth || corner.stops) return corner;
  // Half of each piece is reserved for the corner at its other end.
  const double half = pieces.front().length() / 2.0;
  auto rounded = blend(last_.back(), pieces.front(), joint, tolerance_, std::min(last_half_, half));
  if (!rounded) return tl::unexpected(std::move(rounded.error()));
  if (auto possible = checked(rounded->pieces); !possible) return tl::unexpected(std::move(possible.error()));
  last_.back() = last_.back().part(0.0, last_.back().length() - rounded->cut);
  pieces.front() = pieces.front().part(rounded->cut, pieces.front().length());
  corner.cut = rounded->cut;
  corner.pieces = std::move(rounded->pieces);
  return corner;
}

tl::expected<void, PathMoveError> PathShaper::add(const PathMove& move, std::vector<ShapedPiece>& out) {
  if (auto checked = check_move(move, axes_); !checked) return checked;
  auto pieces = shaped(move);
  if (!pieces) return tl::unexpected(std::move(pieces.error()));
  const auto number = moves_;
  const double length = length_of(*pieces);
  auto events = events_of(move, length);
  if (!events) return tl::unexpected(std::move(events.error()));
  if (events->size() + (pieces->empty() || last_.empty() ? events_.size() : 0) > kMaxOutputsOfMove) {
    return too_many_events();
  }
  if (pieces->empty()) {
    add_without_way(move);
    return {};
  }
  if (auto possible = checked(*pieces); !possible) return possible;
  const double end_half = pieces->back().length() / 2.0;
  const auto corner = join(*pieces);
  if (!corner) return tl::unexpected(corner.error());
  const auto on_corner = take_events_of_corner(corner->cut, length_of(corner->pieces), *events);
  // Events that waited for the first move come before it.
  if (last_.empty()) events->insert(events->begin(), events_.begin(), events_.end());
  hand_over(out, corner->stops);
  put_pieces(corner->pieces, std::min(feed_, move.feed), number, on_corner, out);
  events_ = std::move(*events);
  dwells_ = move.dwell_s > 0.0;
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
