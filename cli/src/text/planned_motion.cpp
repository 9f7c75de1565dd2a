#include "text/planned_motion.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::cli {
namespace {

using trajectory::GroupVector;

constexpr std::size_t kCycles = 4;

void keep(std::deque<GroupVector>& last, const GroupVector& next) {
  last.push_front(next);
  if (last.size() > kCycles) last.pop_back();
}

/// Velocity, acceleration and jerk of an axis from its last four positions.
std::array<double, 3> differences(const std::deque<GroupVector>& last, std::size_t axis, double period_s) {
  const double first = last[0][axis] - last[1][axis];
  const double second = first - (last[1][axis] - last[2][axis]);
  const double third = second - (last[1][axis] - 2.0 * last[2][axis] + last[3][axis]);
  return {first / period_s, second / (period_s * period_s), third / (period_s * period_s * period_s)};
}

}  // namespace

void MotionMeter::take(const trajectory::ContourSetpoint& setpoint) {
  keep(positions_, setpoint.position);
  keep(tools_, setpoint.tool);
  const double time_s = static_cast<double>(++cycles_) * period_s_;
  motion_.duration_s = time_s;
  motion_.length = std::max(motion_.length, setpoint.length);
  if (setpoint.dwells) motion_.dwell_s += period_s_;
  for (const auto& change : setpoint.changed_outputs()) {
    motion_.outputs.push_back({time_s, change, setpoint.move, setpoint.tool});
  }
  constexpr std::size_t kCyclesPerPoint = 16;
  if (cycles_ % kCyclesPerPoint == 1) motion_.points.push_back({time_s, setpoint.tool, setpoint.speed});
  if (positions_.size() < kCycles) return;
  std::array<double, 3> squares{};
  for (std::size_t i = 0; i < trajectory::kMaxGroupAxes; ++i) {
    const auto of_axis = differences(positions_, i, period_s_);
    const auto of_tool = differences(tools_, i, period_s_);
    for (std::size_t k = 0; k < of_axis.size(); ++k) {
      motion_.largest[k][i] = std::max(motion_.largest[k][i], std::abs(of_axis[k]));
      squares[k] += of_tool[k] * of_tool[k];
    }
  }
  for (std::size_t k = 0; k < squares.size(); ++k) {
    motion_.largest_of_tool[k] = std::max(motion_.largest_of_tool[k], std::sqrt(squares[k]));
  }
}

}  // namespace driveline::cli
