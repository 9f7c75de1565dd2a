#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "driveline/trajectory/contour_follower.hpp"

namespace driveline::cli {

/// An output that changed on the way.
struct PlannedOutput {
  double time_s;
  trajectory::PathOutput change;
  std::uint64_t move;
  trajectory::GroupVector tool;
};

/// Where a planned motion was in a cycle.
struct PlannedPoint {
  double time_s;
  trajectory::GroupVector tool;
  double speed;
};

/// What axes and tool were asked for, by differences of their positions.
struct PlannedMotion {
  double duration_s = 0.0;
  double length = 0.0;
  double dwell_s = 0.0;
  std::array<trajectory::GroupVector, 3> largest{};  ///< velocity, acceleration, jerk of the axes
  std::array<double, 3> largest_of_tool{};           ///< the same of the tool
  std::vector<PlannedOutput> outputs;
  std::vector<PlannedPoint> points;  ///< some of the cycles, for the picture
};

/// Collects a motion cycle by cycle.
class MotionMeter {
 public:
  explicit MotionMeter(double period_s) : period_s_(period_s) {}

  void take(const trajectory::ContourSetpoint& setpoint);
  PlannedMotion result() { return std::move(motion_); }

 private:
  double period_s_;
  std::deque<trajectory::GroupVector> positions_;  ///< of the last four cycles, latest first
  std::deque<trajectory::GroupVector> tools_;
  std::size_t cycles_ = 0;
  PlannedMotion motion_;
};

}  // namespace driveline::cli
