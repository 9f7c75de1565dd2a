#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "group_path.hpp"
#include "range_check.hpp"

namespace driveline::motion {

/// Path of a group of up to trajectory::kMaxGroupAxes axes: lines, arcs and splines with rounded corners.
class ContourPath final : public GroupPath {
 public:
  /// `start`: positions of the axes; `outputs`: null if there are none. Throws std::invalid_argument if
  /// trajectory::ContourTrack does, or if the kinematics give other joint positions for the tool position.
  ContourPath(const trajectory::ContourSettings& settings, RangeCheck ranges, std::span<const double> start,
              std::uint64_t epoch, PathOutputs* outputs);

  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> add(const GroupMove& move) override;
  void finish() override { planner_.finish(); }
  [[nodiscard]] bool flush() override { return planner_.flush(); }
  [[nodiscard]] std::span<const double> target() const noexcept override { return {planner_.target().data(), axes_}; }
  void set_override(double share) noexcept override { static_cast<void>(follower_.set_override(share)); }
  void hold(bool held) noexcept override { follower_.hold(held); }
  void reverse(bool backwards) noexcept override { follower_.reverse(backwards); }
  Place step(std::span<trajectory::AxisSetpoint> setpoints) noexcept override;

 private:
  std::size_t axes_;
  RangeCheck ranges_;
  double tolerance_before_ = 0.0;
  PathOutputs* outputs_;
  trajectory::ContourTrack track_;
  trajectory::ContourPlanner planner_;
  trajectory::ContourFollower follower_;
};

}  // namespace driveline::motion
