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
  return absences_[axis].braking && on_the_ramp && seconds(cycle - absences_[axis].since) < most;
}

void Motion::set_presence(std::size_t axis, AxisPresence presence, std::int64_t cycle) noexcept {
  absences_[axis].presence = presence;
  absences_[axis].since = cycle;
  absences_[axis].braking = false;
  presence_shared_[axis].store(presence, std::memory_order_release);
}

/// Failure cause for an axis that is not enabled in time.
MotionFailure::Cause Motion::enable_failure(std::size_t axis) const noexcept {
  return position_watches_[axis].unsteady() ? MotionFailure::Cause::kPositionUnsteady
                                            : MotionFailure::Cause::kEnableTimeout;
}

/// An axis is finally missing only once the others have power: if it becomes available in time, it is enabled with
/// them.
void Motion::watch_enabling(std::int64_t cycle) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const bool missing = absences_[i].presence == AxisPresence::kMissing;
    if (tolerated(i) && missing != unavailable(i))
      set_presence(i, missing ? AxisPresence::kPresent : AxisPresence::kMissing, cycle);
    if (arresting(i) && following_watches_[i].judge(cycle, axes_[i].following_error(), true))
      return fail(MotionFailure::Cause::kFollowingError, i, cycle);
    if (absences_[i].presence == AxisPresence::kMissing || axes_[i].ready()) continue;
    const double waited = seconds(cycle - std::max(phase_start_, absences_[i].since));
    if (waited > std::chrono::duration<double>(settings_.enable_timeout).count())
      return fail(enable_failure(i), i, cycle);
  }
}

void Motion::watch_absence(std::size_t axis, std::int64_t cycle) noexcept {
  auto& absence = absences_[axis];
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
                                 supplies_[axis].given.by_torque(), axes_[axis].config().limits};
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
    const bool present = absences_[i].presence == AxisPresence::kPresent;
    if (!present && axes_[i].config().on_loss == LossPolicy::kHold) return true;
    nobody = nobody && !present;
  }
  return nobody;
}

bool Motion::reset_due(std::size_t axis, std::int64_t cycle) const noexcept {
  const bool enabling =
      phase_ == MotionPhase::kEnabling || (powered() && absences_[axis].presence == AxisPresence::kEnabling);
  return enabling && cycle % (2 * kResetCycles) < kResetCycles;
}

cia402::Goal Motion::goal(std::size_t axis) const noexcept {
  using cia402::Goal;
  if (phase_ == MotionPhase::kQuickStop) return Goal::kQuickStop;
  // Needs a steady position, because the axis will hold the position at which it is enabled, or brake from there.
  const auto enabled = coast_watches_[axis].goal(axes_[axis], position_watches_[axis].steady(), seen_[axis] != 0);
  if (phase_ != MotionPhase::kEnabling && !powered()) return Goal::kDisabled;
  switch (absences_[axis].presence) {
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
