// Enabling of all axes together.
#include <algorithm>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {

/// Starts the approach when all axes have power, follow setpoints, and are at standstill.
void Motion::advance_enabling(std::int64_t cycle) noexcept {
  bool at_rest = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) at_rest = arrest(i) && at_rest;
  if (!at_rest || !all_ready()) return;
  std::copy(setpoints_.begin(), setpoints_.end(), targets_.begin());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i].enabled()) anchor(i);
    supply_from_rest(i);
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i].enabled() && !begins_in_range(i, cycle)) return;
  }
  plan_approach();
  enter(MotionPhase::kApproach, cycle);
}

/// Brakes an axis that coasts when it is enabled, within its limits, and holds it where it comes to rest; an axis at
/// standstill is held at once. Returns false until the axis is at rest.
bool Motion::arrest(std::size_t axis) noexcept {
  auto& [stop, given] = each_[axis].arrest;
  auto& supply = each_[axis].supply;
  if (!axes_[axis].stays_on()) {
    setpoints_[axis] = axes_[axis].held();
    supply.beside_path = false;
    stop.reset();
    return true;
  }
  if (!stop) {
    stop = trajectory::StopProfile::plan(setpoints_[axis], {axes_[axis].config().limits.max_acceleration});
    given = 0;
  }
  if (!supply.given.reached()) {
    bridge(axis);
    return false;
  }
  if (stop) targets_[axis] = stop->evaluate(seconds(++given));
  setpoints_[axis] = aim_present(axis);
  return !arresting(axis);
}

/// Ends the enabling. Without power an axis that is being braked would coast again, so its drive stops it.
void Motion::abandon_enabling(std::int64_t cycle) noexcept {
  bool braked = false;
  for (std::size_t i = 0; i < axes_.size(); ++i) braked = braked || arresting(i);
  enter(braked ? MotionPhase::kQuickStop : MotionPhase::kDisabling, cycle);
}

/// Whether the axis is still being braked.
bool Motion::arresting(std::size_t axis) const noexcept {
  const auto& [stop, given] = each_[axis].arrest;
  return phase_ == MotionPhase::kEnabling && stop &&
         (!stop->finished(seconds(given)) || each_[axis].supply.beside_path);
}

}  // namespace driveline::motion
