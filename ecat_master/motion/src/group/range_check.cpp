#include "range_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "driveline/trajectory/path_shaper.hpp"

namespace driveline::motion {
namespace {

/// Number of positions of a piece that are checked; between them its curvature is within its bounds.
constexpr int kPlaces = 128;
/// First derivatives up to this value have no direction.
constexpr double kStands = 1e-9;

}  // namespace

tl::expected<void, trajectory::PathMoveError> RangeCheck::judge(std::size_t axis, double position,
                                                                double margin) const {
  const auto& [name, range] = ranges_[axis];
  if (!range || (position - margin >= range->min && position + margin <= range->max)) return {};
  return tl::unexpected(
      trajectory::PathMoveError{fmt::format("axis '{}' would get to {:.6g}; its software limits are {:.6g} and {:.6g}",
                                            name, position, range->min, range->max)});
}

tl::expected<void, trajectory::PathMoveError> RangeCheck::place(std::span<const double> at) const {
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (auto judged = judge(i, at[i], 0.0); !judged) return judged;
  }
  return {};
}

// Where an axis reverses between two positions it exceeds both, by no more than the bounds permit.
tl::expected<void, trajectory::PathMoveError> RangeCheck::piece(const trajectory::PathPiece& piece,
                                                                double margin) const {
  const double step = piece.length() / kPlaces;
  auto before = piece.at(0.0);
  for (int k = 0; k < kPlaces; ++k) {
    const double end = std::min(piece.length(), step * (k + 1));
    const auto bounds = piece.bounds(step * k, end);
    const auto there = piece.at(end);
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      const bool turns =
          std::min(before.first[i], there.first[i]) < -kStands && std::max(before.first[i], there.first[i]) > kStands;
      const double beyond = turns ? 0.125 * bounds.second[i] * step * step : 0.0;
      if (auto judged = judge(i, before.position[i], margin + beyond); !judged) return judged;
      if (auto judged = judge(i, there.position[i], margin + beyond); !judged) return judged;
    }
    before = there;
  }
  return {};
}

// The rounded corner of two lines lies between them. Other corners may leave both moves by their tolerance.
tl::expected<void, trajectory::PathMoveError> RangeCheck::move(const trajectory::GroupVector& from,
                                                               const trajectory::PathMove& move,
                                                               double tolerance_before) const {
  const bool limited = std::any_of(ranges_.begin(), ranges_.end(), [](const Range& each) { return each.range; });
  if (!limited) return {};
  if (move.kind == trajectory::PathMove::Kind::kLine) return place(move.target);
  trajectory::PathShaper shaper(ranges_.size(), from);
  std::vector<trajectory::ShapedPiece> pieces;
  if (!shaper.add(move, pieces)) return {};
  shaper.finish(pieces);
  for (const auto& shaped : pieces) {
    if (auto judged = piece(shaped.piece, std::max(move.tolerance, tolerance_before)); !judged) return judged;
  }
  return {};
}

}  // namespace driveline::motion
