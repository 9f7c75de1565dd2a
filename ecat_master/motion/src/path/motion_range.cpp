// Software limits of axes that move together.
#include <algorithm>
#include <cmath>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {

void Motion::set_ranges() {
  constexpr double kRounding = 1e-9;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto& config = axes_[i].config();
    each_[i].reach.way_per_square = 0.5 / config.limits.max_acceleration;
    if (!config.software_limits) continue;
    const double margin = kRounding * (config.software_limits->max - config.software_limits->min);
    each_[i].reach.lowest = config.software_limits->min - margin;
    each_[i].reach.highest = config.software_limits->max + margin;
    limited_ = true;
  }
}

/// Checks an enabled axis before it moves. The extent of a path is known, of another source only the start.
bool Motion::begins_in_range(std::size_t axis, std::int64_t cycle) noexcept {
  if (!limited_) return true;
  const bool path = !extents_.empty() && source_ == path_.get();
  const double anchor = each_[axis].anchor.value_or(0.0);
  const double lowest = path ? extents_[axis].lowest + anchor : source_start_[axis].position;
  const double highest = path ? extents_[axis].highest + anchor : source_start_[axis].position;
  const bool below = lowest < each_[axis].reach.lowest;
  if (!below && highest <= each_[axis].reach.highest) return true;
  fail(MotionFailure::Cause::kOutsideRange, axis, cycle, below ? lowest : highest);
  return false;
}

/// Position where the axis would come to rest if it were stopped now. A path has been checked as a whole.
double Motion::reach(std::size_t axis) const noexcept {
  const auto& target = targets_[axis];
  const bool torque_alone = target.torque && axes_[axis].config().mode == cia402::Mode::kCyclicTorque;
  const auto& inputs = axes_[axis].inputs();
  const double position = torque_alone ? inputs.position : target.position;
  const double step = (target.position - each_[axis].before) / seconds(1);
  const double faster = std::abs(step) > std::abs(target.velocity) ? step : target.velocity;
  const double velocity = torque_alone ? inputs.velocity : faster;
  return position + velocity * std::abs(velocity) * each_[axis].reach.way_per_square;
}

bool Motion::leaves_range(std::size_t axis) const noexcept {
  const double at = reach(axis);
  return at < each_[axis].reach.lowest || at > each_[axis].reach.highest;
}

bool Motion::in_ranges() const noexcept {
  if (!limited_ || source_ == path_.get()) return true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (leaves_range(i)) return false;
  }
  return true;
}

}  // namespace driveline::motion
