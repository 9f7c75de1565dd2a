#include "driveline/runtime/groups/group_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "driveline/trajectory/path_check.hpp"
#include "driveline/trajectory/path_shaper.hpp"
#include "driveline/trajectory/profile_error.hpp"

namespace driveline::runtime {
namespace {

/// Number of points at which a curved piece is checked.
constexpr int kPlaces = 32;
/// Share of a range within which exceeding an end counts as rounding.
constexpr double kRounding = 1e-9;

std::optional<GroupRefusal> check_place(const MoveLimits& limits, const trajectory::GroupVector& place) {
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

/// Checks that the path, at its feed, lasts no longer than a profile can.
std::optional<GroupRefusal> check_duration(const MoveLimits& limits, const std::vector<trajectory::ShapedPiece>& pieces,
                                           double feed) {
  double length = 0.0;
  for (const auto& shaped : pieces) length += shaped.piece.length();
  const double least = length / trajectory::kLongestProfileSeconds;
  if (!(feed > 0.0) || feed >= least) return std::nullopt;
  const auto& unit =
      limits.group.coordinates.empty() ? limits.group.axes.front().unit : limits.group.coordinates.front().unit;
  return unusable(
      fmt::format("the move would take longer than {} s, the longest that is possible; a feed of at least "
                  "{:.6g} {}/s is expected",
                  trajectory::kLongestProfileSeconds, unit.from_si(least), unit.name));
}

}  // namespace

const trajectory::GroupVector& end_of(const trajectory::PathMove& move) {
  return move.kind == trajectory::PathMove::Kind::kSpline && !move.points.empty() ? move.points.back() : move.target;
}

trajectory::ContourSettings joint_settings(const MoveLimits& limits) {
  trajectory::ContourSettings settings;
  settings.axes = limits.group.axes.size();
  if (limits.machine) settings.kinematics = &limits.machine->kinematics();
  for (std::size_t i = 0; i < limits.ranges.size(); ++i) {
    if (!limits.ranges[i]) continue;
    settings.limits.at(i).min_position = limits.ranges[i]->min;
    settings.limits.at(i).max_position = limits.ranges[i]->max;
  }
  return settings;
}

std::vector<trajectory::NamedAxis> named_axes(const events::EventGroup& group) {
  std::vector<trajectory::NamedAxis> named;
  named.reserve(group.axes.size());
  // The units come from a table with static lifetime.
  for (const auto& axis : group.axes) named.push_back({axis.name, trajectory::find_position_unit(axis.unit.name)});
  return named;
}

std::optional<GroupRefusal> check_outputs(const MoveLimits& limits, const trajectory::PathMove& move) {
  for (const auto& output : move.outputs) {
    if (output.change.output >= limits.outputs.size())
      return unusable("the move sets an output that the group does not have");
    const auto& [name, least, most] = limits.outputs[output.change.output];
    const double value = output.change.value;
    if (value >= least && value <= most && std::floor(value) == value) continue;
    return unusable(fmt::format("the value of {} is {:.6g}, a whole number from {:.0f} to {:.0f} is expected", name,
                                value, least, most));
  }
  return std::nullopt;
}

std::optional<GroupRefusal> check_group_move(const MoveLimits& limits, const trajectory::GroupVector& from,
                                             const trajectory::PathMove& move) {
  if (auto wrong = check_outputs(limits, move)) return wrong;
  const auto settings = joint_settings(limits);
  const trajectory::PathCheck machine(settings, named_axes(limits.group));
  std::vector<trajectory::ShapedPiece> pieces;
  try {
    trajectory::PathShaper shaper(limits.group.axes.size(), from, limits.machine ? &machine : nullptr);
    if (auto added = shaper.add(move, pieces); !added) return unusable(added.error().reason);
    shaper.finish(pieces);
  } catch (const std::invalid_argument& wrong) {
    return unusable(wrong.what());
  }
  if (auto wrong = check_duration(limits, pieces, move.feed)) return wrong;
  if (limits.machine) return std::nullopt;
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
