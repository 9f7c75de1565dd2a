#include "contour_path.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace driveline::motion {
namespace {

trajectory::GroupVector vector_of(std::span<const double> values) {
  trajectory::GroupVector made{};
  std::copy(values.begin(), values.end(), made.begin());
  return made;
}

/// Joint positions that differ by no more than this count as equal, rad or m.
constexpr double kSameJoint = 1e-6;

/// Position of the tool for these joint positions.
trajectory::GroupVector tool_at(const trajectory::ContourSettings& settings, std::span<const double> axes) {
  const auto joints = vector_of(axes);
  if (settings.kinematics == nullptr) return joints;
  trajectory::PathGeometry tool;
  tool.position = joints;
  if (!settings.kinematics->forward(joints, tool.position))
    throw std::invalid_argument("the joints of the machine are in an impossible combination of positions");
  trajectory::PathGeometry back;
  back.position = joints;
  const auto fault = settings.kinematics->inverse(tool, back);
  if (fault.kind != trajectory::PoseFault::Kind::kNone)
    throw std::invalid_argument("no path can start at the present position of the tool: " +
                                settings.kinematics->explain(fault));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!(std::abs(back.position[i] - joints[i]) <= kSameJoint))
      throw std::invalid_argument("joint " + std::to_string(i + 1) +
                                  " is at a position that does not match the machine with its tool there");
  }
  return tool.position;
}

}  // namespace

ContourPath::ContourPath(const trajectory::ContourSettings& settings, RangeCheck ranges, std::span<const double> start,
                         std::uint64_t epoch, PathOutputs* outputs)
    : GroupPath(epoch),
      axes_(start.size()),
      ranges_(std::move(ranges)),
      outputs_(outputs),
      track_(settings, tool_at(settings, start)),
      planner_(track_),
      follower_(track_) {}

tl::expected<void, trajectory::PathMoveError> ContourPath::add(const GroupMove& move) {
  auto path = move.path;
  if (!move.target.empty()) {
    if (move.target.size() != axes_) return tl::unexpected(wrong_count(move.target.size(), axes_));
    path.target = vector_of(move.target);
  }
  if (!path.outputs.empty() && outputs_ == nullptr)
    return tl::unexpected(trajectory::PathMoveError{"the move changes outputs, but the group has none"});
  if (auto in_range = ranges_.move(planner_.target(), path, tolerance_before_); !in_range) return in_range;
  if (auto added = planner_.add(path); !added) return added;
  tolerance_before_ = path.tolerance;
  return {};
}

GroupPath::Place ContourPath::step(std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  const auto at = follower_.step();
  for (std::size_t i = 0; i < axes_; ++i) setpoints[i] = {at.position[i], at.velocity[i], at.acceleration[i]};
  for (const auto& changed : at.changed_outputs()) outputs_->change(changed);
  return {at.move, at.length, at.speed, at.at_rest, at.at_end};
}

}  // namespace driveline::motion
