#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "driveline/trajectory/contour_follower.hpp"

namespace driveline::cli {

/// An output that changed during the motion.
struct PlannedOutput {
  double time_s;
  trajectory::PathOutput change;
  std::uint64_t move;
  trajectory::GroupVector tool;
};

/// Position and speed of a planned motion in a cycle.
struct PlannedPoint {
  double time_s;
  trajectory::GroupVector tool;
  double speed;
};

/// A planned motion with the maxima of axes and tool, from differences of their positions.
struct PlannedMotion {
  double duration_s = 0.0;
  double length = 0.0;
  double dwell_s = 0.0;
  std::array<trajectory::GroupVector, 3> largest{};  ///< velocity, acceleration, jerk of the axes
  std::array<double, 3> largest_of_tool{};           ///< the same of the tool
  std::vector<PlannedOutput> outputs;
  std::vector<PlannedPoint> points;  ///< selected cycles, for the picture
};

/// Collects the setpoints of a motion cycle by cycle.
class MotionMeter {
 public:
  explicit MotionMeter(double period_s) : period_s_(period_s) {}

  void take(const trajectory::ContourSetpoint& setpoint);
  PlannedMotion result() { return std::move(motion_); }

 private:
  double period_s_;
  std::deque<trajectory::GroupVector> positions_;  ///< positions of the last four cycles, latest first
  std::deque<trajectory::GroupVector> tools_;
  std::size_t cycles_ = 0;
  PlannedMotion motion_;
};

}  // namespace driveline::cli
