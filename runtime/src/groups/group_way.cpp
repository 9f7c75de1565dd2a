#include "driveline/runtime/groups/group_way.hpp"

#include <stdexcept>
#include <utility>

#include "driveline/trajectory/path_shaper.hpp"

namespace driveline::runtime {
namespace {

/// Places of a curved piece that are looked at.
constexpr int kPlaces = 32;
/// Of a range; beyond an end by less is rounding.
constexpr double kRounding = 1e-9;

std::optional<GroupRefusal> check_place(const WayLimits& limits, const trajectory::GroupVector& place) {
  for (std::size_t i = 0; i < limits.ranges.size(); ++i) {
    const auto& range = limits.ranges[i];
    if (!range) continue;
    const double most = kRounding * (range->max - range->min);
    if (place.at(i) >= range->min - most && place.at(i) <= range->max + most) continue;
    GroupRefusal refusal;
    refusal.why = GroupRefusal::Why::kOutsideRange;
    refusal.axis = limits.group.axes.at(i);
    refusal.value = place.at(i);
    refusal.lowest = range->min;
    refusal.highest = range->max;
    return refusal;
  }
  return std::nullopt;
}

GroupRefusal unusable(std::string reason) {
  GroupRefusal refusal;
  refusal.why = GroupRefusal::Why::kBadMove;
  refusal.reason = std::move(reason);
  return refusal;
}

}  // namespace

const trajectory::GroupVector& end_of(const trajectory::PathMove& move) {
  return move.kind == trajectory::PathMove::Kind::kSpline && !move.points.empty() ? move.points.back() : move.target;
}

std::optional<GroupRefusal> check_way(const WayLimits& limits, const trajectory::GroupVector& from,
                                      const trajectory::PathMove& move) {
  std::vector<trajectory::ShapedPiece> pieces;
  try {
    trajectory::PathShaper shaper(limits.group.axes.size(), from);
    if (auto added = shaper.add(move, pieces); !added) return unusable(added.error().reason);
    shaper.finish(pieces);
  } catch (const std::invalid_argument& wrong) {
    return unusable(wrong.what());
  }
  for (const auto& shaped : pieces) {
    const auto& piece = shaped.piece;
    const int places = piece.is_line() ? 1 : kPlaces;
    for (int k = 1; k <= places; ++k) {
      if (auto wrong = check_place(limits, piece.at(piece.length() * k / places).position)) return wrong;
    }
  }
  return std::nullopt;
}

}  // namespace driveline::runtime
