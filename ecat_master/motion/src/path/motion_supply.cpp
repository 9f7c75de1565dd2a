// Setpoints if not all of them reach the drives.
#include <cmath>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {

/// Records the setpoints sent in this cycle and the resulting state of the drives.
void Motion::note_supplies() noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) each_[i].supply.given.note(setpoints_[i], axes_[i].mode_in_force());
}

/// The axis is at rest at its setpoint.
void Motion::supply_from_rest(std::size_t axis) noexcept {
  each_[axis].supply.given.start_from({setpoints_[axis].position, 0.0, 0.0});
  each_[axis].supply.beside_path = false;
}

/// All axes follow the path together, so it waits if an axis did not get its setpoint, except axes whose loss does not
/// stop the others.
bool Motion::path_must_wait_for_setpoints() const noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto presence = each_[i].absence.presence;
    const bool takes_part = presence == AxisPresence::kPresent || presence == AxisPresence::kReturning;
    if (takes_part && !each_[i].supply.given.reached() && axes_[i].config().on_loss != LossPolicy::kContinue)
      return true;
  }
  return false;
}

/// Continues from the position that the drive has reached without its setpoint.
void Motion::bridge(std::size_t axis) noexcept {
  auto& supply = each_[axis].supply;
  const auto presence = each_[axis].absence.presence;
  if (presence == AxisPresence::kMissing || presence == AxisPresence::kEnabling) {
    setpoints_[axis] = axes_[axis].held();
    return;
  }
  setpoints_[axis] = supply.given.bridge(held_up_);
  supply.beside_path = true;
  supply.return_motion.reset();
}

trajectory::AxisSetpoint Motion::aim_present(std::size_t axis) noexcept {
  auto& supply = each_[axis].supply;
  if (!supply.beside_path) return targets_[axis];
  if (!supply.return_motion) supply.return_motion.emplace(supply.given, axes_[axis].config().limits);
  const auto setpoint = supply.return_motion->step(targets_[axis], seconds(1), axes_[axis].changing());
  if (supply.return_motion->joined()) supply.beside_path = false;
  return setpoint;
}

/// Computes the setpoints of this cycle: on the path, on the return to it, or at the position of the axis.
void Motion::aim() noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    auto& absence = each_[i].absence;
    auto& supply = each_[i].supply;
    if (!supply.given.reached()) {
      bridge(i);
    } else if (absence.presence == AxisPresence::kPresent) {
      setpoints_[i] = aim_present(i);
    } else if (absence.presence == AxisPresence::kReturning) {
      if (supply.beside_path) absence.return_motion = {supply.given, axes_[i].config().limits};
      supply.beside_path = false;
      setpoints_[i] = absence.return_motion.step(targets_[i], seconds(1), axes_[i].changing());
      if (absence.return_motion.joined()) set_presence(i, AxisPresence::kPresent, phase_start_);
    } else {
      setpoints_[i] = axes_[i].held();
      supply.beside_path = false;
    }
  }
}

void Motion::fall_behind(std::int64_t periods) noexcept {
  if (phase_ != MotionPhase::kApproach && phase_ != MotionPhase::kFollowing) return;
  source_->fall_behind(seconds(periods));
  tell_path_late();
}

void Motion::tell_path_late() noexcept {
  path_late_shared_.store(std::llround(source_->behind_s() * 1e9), std::memory_order_relaxed);
}

/// Whether an absence of the master is so long that the position of the drive cannot be predicted. What the drive
/// lacked before counts, too: behind an absence on CAN the setpoint of the period before has not taken effect either.
bool Motion::too_long(std::size_t axis, std::int64_t missed) const noexcept {
  return missed + each_[axis].supply.given.lacking() > std::int64_t{each_[axis].lost_limit} * axes_[axis].divider();
}

AbsenceEffect Motion::resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept {
  bool moving = powered();
  bool bridged = false;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    moving = moving || arresting(i);
    bridged = bridged || !too_long(i, missed);
  }
  // A coasting axis kept moving: enable it only after its position was read again, else extrapolate its motion.
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i].stays_on()) continue;
    each_[i].seen = 0;
    axes_[i].coast_on(seconds(missed));
    if (too_long(i, missed) && each_[i].coast_watch.coasts()) forget_place(i);
    if (phase_ == MotionPhase::kEnabling) setpoints_[i] = axes_[i].held();
  }
  if (!moving) {
    for (std::size_t i = 0; i < axes_.size() && phase_ == MotionPhase::kEnabling; ++i)
      axes_[i].write_outputs(image, goal(i), reset_due(i, cycle), setpoints_[i]);
    return AbsenceEffect::kNone;
  }
  if (bridged) fall_behind(missed);
  auto effect = AbsenceEffect::kBridged;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!powered() && !arresting(i)) continue;
    if (too_long(i, missed)) {
      give_up(i, cycle);
      effect = AbsenceEffect::kStopped;
      continue;
    }
    each_[i].supply.given.skip(missed, axes_[i].mode_in_force());
    axes_[i].skip(missed);
    bridge(i);
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    axes_[i].write_outputs(image, goal(i), reset_due(i, cycle), setpoints_[i]);
  }
  return effect;
}

/// The position of the drive cannot be predicted any more, so it stops on its own. An axis with a loss policy is
/// treated as if it had been missing; any other axis stops all axes.
void Motion::give_up(std::size_t axis, std::int64_t cycle) noexcept {
  if (!tolerated(axis) || phase_ == MotionPhase::kEnabling) return fail(MotionFailure::Cause::kMasterAway, axis, cycle);
  set_presence(axis, AxisPresence::kMissing, cycle);
  each_[axis].absence.braking = true;
}

}  // namespace driveline::motion
