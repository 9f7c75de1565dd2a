// Axes that are missing for a while, and return.
#include <algorithm>
#include <cmath>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {
namespace {

/// A fault reset needs one cycle with bit 7 set and one with it cleared; several of each tolerate a lost frame.
constexpr std::int64_t kResetCycles = 4;

}  // namespace

bool Motion::unavailable(std::size_t axis) const noexcept {
  return axes_[axis].inputs().state == snapshot::AxisState::kUnavailable;
}

/// Whether the drive is still on the ramp of its quick stop, or has not received the command yet.
bool Motion::brakes(std::size_t axis, std::int64_t cycle) const noexcept {
  const auto state = axes_[axis].inputs().state;
  const bool on_the_ramp =
      state == snapshot::AxisState::kOperationEnabled || state == snapshot::AxisState::kQuickStopActive;
  const double most = std::chrono::duration<double>(settings_.quick_stop_time).count();
  return each_[axis].absence.braking && on_the_ramp && seconds(cycle - each_[axis].absence.since) < most;
}

void Motion::set_presence(std::size_t axis, AxisPresence presence, std::int64_t cycle) noexcept {
  each_[axis].absence.presence = presence;
  each_[axis].absence.since = cycle;
  each_[axis].absence.braking = false;
  presence_shared_[axis].store(presence, std::memory_order_release);
}

/// Failure cause for an axis that is not enabled in time.
MotionFailure::Cause Motion::enable_failure(std::size_t axis) const noexcept {
  return each_[axis].position_watch.unsteady() ? MotionFailure::Cause::kPositionUnsteady
                                               : MotionFailure::Cause::kEnableTimeout;
}

/// An axis is finally missing only once the others have power: if it becomes available in time, it is enabled with
/// them.
void Motion::watch_enabling(std::int64_t cycle) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const bool missing = each_[i].absence.presence == AxisPresence::kMissing;
    if (tolerated(i) && missing != unavailable(i))
      set_presence(i, missing ? AxisPresence::kPresent : AxisPresence::kMissing, cycle);
    if (arresting(i) && each_[i].following_watch.judge(cycle, axes_[i].following_error(), true))
      return fail(MotionFailure::Cause::kFollowingError, i, cycle);
    if (each_[i].absence.presence == AxisPresence::kMissing || axes_[i].ready()) continue;
    const double waited = seconds(cycle - std::max(phase_start_, each_[i].absence.since));
    if (waited > std::chrono::duration<double>(settings_.enable_timeout).count())
      return fail(enable_failure(i), i, cycle);
  }
}

void Motion::watch_absence(std::size_t axis, std::int64_t cycle) noexcept {
  auto& absence = each_[axis].absence;
  if (unavailable(axis)) {
    if (absence.presence != AxisPresence::kMissing) set_presence(axis, AxisPresence::kMissing, cycle);
    return;
  }
  switch (absence.presence) {
    case AxisPresence::kPresent:
    case AxisPresence::kReturning:
      break;
    case AxisPresence::kMissing:
      // During a stop no axis is enabled any more.
      if (phase_ != MotionPhase::kStopping && !brakes(axis, cycle)) set_presence(axis, AxisPresence::kEnabling, cycle);
      break;
    case AxisPresence::kEnabling:
      // Brake a coasting axis at once; an axis at standstill waits for its brake.
      if (axes_[axis].ready() || (axes_[axis].stays_on() && std::abs(setpoints_[axis].velocity) > 0.0)) {
        anchor(axis);
        if (!begins_in_range(axis, cycle)) return;
        // Start with its present velocity, because it may coast.
        absence.return_motion = {setpoints_[axis].position, setpoints_[axis].velocity,
                                 each_[axis].supply.given.by_torque(), axes_[axis].config().limits};
        set_presence(axis, AxisPresence::kReturning, cycle);
      } else if (seconds(cycle - absence.since) > std::chrono::duration<double>(settings_.enable_timeout).count()) {
        fail(enable_failure(axis), axis, cycle);
      }
      break;
  }
}

bool Motion::must_wait() const noexcept {
  bool nobody = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const bool present = each_[i].absence.presence == AxisPresence::kPresent;
    if (!present && axes_[i].config().on_loss == LossPolicy::kHold) return true;
    nobody = nobody && !present;
  }
  return nobody;
}

bool Motion::reset_due(std::size_t axis, std::int64_t cycle) const noexcept {
  const bool enabling =
      phase_ == MotionPhase::kEnabling || (powered() && each_[axis].absence.presence == AxisPresence::kEnabling);
  return enabling && cycle % (2 * kResetCycles) < kResetCycles;
}

cia402::Goal Motion::goal(std::size_t axis) const noexcept {
  using cia402::Goal;
  if (phase_ == MotionPhase::kQuickStop) return Goal::kQuickStop;
  // Needs a steady position, because the axis will hold the position at which it is enabled, or brake from there.
  const auto enabled =
      each_[axis].coast_watch.goal(axes_[axis], each_[axis].position_watch.steady(), each_[axis].seen != 0);
  if (phase_ != MotionPhase::kEnabling && !powered()) return Goal::kDisabled;
  switch (each_[axis].absence.presence) {
    case AxisPresence::kMissing:
      // The axis may still receive outputs and be moving.
      return phase_ == MotionPhase::kEnabling ? Goal::kDisabled : Goal::kQuickStop;
    case AxisPresence::kEnabling:
      return phase_ == MotionPhase::kStopping ? Goal::kDisabled : enabled;
    case AxisPresence::kPresent:
    case AxisPresence::kReturning:
      break;
  }
  return enabled;
}

}  // namespace driveline::motion
