// Software limits of axes that move together.
#include <algorithm>
#include <cmath>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {

void Motion::set_ranges() {
  constexpr double kRounding = 1e-9;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto& config = axes_[i].config();
    reaches_[i].way_per_square = 0.5 / config.limits.max_acceleration;
    if (!config.software_limits) continue;
    const double margin = kRounding * (config.software_limits->max - config.software_limits->min);
    reaches_[i].lowest = config.software_limits->min - margin;
    reaches_[i].highest = config.software_limits->max + margin;
    limited_ = true;
  }
}

/// Checks an enabled axis before it moves. The extent of a path is known, of another source only the start.
bool Motion::begins_in_range(std::size_t axis, std::int64_t cycle) noexcept {
  if (!limited_) return true;
  const bool path = !extents_.empty() && source_ == path_.get();
  const double anchor = anchors_[axis].value_or(0.0);
  const double lowest = path ? extents_[axis].lowest + anchor : source_start_[axis].position;
  const double highest = path ? extents_[axis].highest + anchor : source_start_[axis].position;
  const bool below = lowest < reaches_[axis].lowest;
  if (!below && highest <= reaches_[axis].highest) return true;
  fail(MotionFailure::Cause::kOutsideRange, axis, cycle, below ? lowest : highest);
  return false;
}

/// Position where the axis would come to rest if it were stopped now. A path has been checked as a whole.
double Motion::reach(std::size_t axis) const noexcept {
  const auto& target = targets_[axis];
  const bool torque_alone = target.torque && axes_[axis].config().mode == cia402::Mode::kCyclicTorque;
  const auto& inputs = axes_[axis].inputs();
  const double position = torque_alone ? inputs.position : target.position;
  const double step = (target.position - before_[axis]) / seconds(1);
  const double faster = std::abs(step) > std::abs(target.velocity) ? step : target.velocity;
  const double velocity = torque_alone ? inputs.velocity : faster;
  return position + velocity * std::abs(velocity) * reaches_[axis].way_per_square;
}

bool Motion::leaves_range(std::size_t axis) const noexcept {
  const double at = reach(axis);
  return at < reaches_[axis].lowest || at > reaches_[axis].highest;
}

bool Motion::in_ranges() const noexcept {
  if (!limited_ || source_ == path_.get()) return true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (leaves_range(i)) return false;
  }
  return true;
}

}  // namespace driveline::motion
