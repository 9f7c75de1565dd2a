#include "contour_path.hpp"

#include <algorithm>
#include <utility>

namespace driveline::ecat_master {
namespace {

trajectory::GroupVector vector_of(std::span<const double> values) {
  trajectory::GroupVector made{};
  std::copy(values.begin(), values.end(), made.begin());
  return made;
}

}  // namespace

ContourPath::ContourPath(const trajectory::ContourSettings& settings, RangeCheck ranges, std::span<const double> start,
                         std::uint64_t epoch)
    : GroupPath(epoch),
      axes_(start.size()),
      ranges_(std::move(ranges)),
      track_(settings, vector_of(start)),
      planner_(track_),
      follower_(track_) {}

tl::expected<void, trajectory::PathMoveError> ContourPath::add(const GroupMove& move) {
  auto path = move.path;
  if (!move.target.empty()) {
    if (move.target.size() != axes_) return tl::unexpected(wrong_count(move.target.size(), axes_));
    path.target = vector_of(move.target);
  }
  if (auto in_range = ranges_.move(planner_.target(), path, tolerance_before_); !in_range) return in_range;
  if (auto added = planner_.add(path); !added) return added;
  tolerance_before_ = path.tolerance;
  return {};
}

GroupPath::Place ContourPath::step(std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  const auto at = follower_.step();
  for (std::size_t i = 0; i < axes_; ++i) setpoints[i] = {at.position[i], at.velocity[i], at.acceleration[i]};
  return {at.move, at.length, at.speed, at.at_rest, at.at_end};
}

}  // namespace driveline::ecat_master
