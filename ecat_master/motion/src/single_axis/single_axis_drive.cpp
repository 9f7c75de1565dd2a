// Movements that the drive of a single axis generates itself: change to their mode, and back to the cyclic mode.
#include <algorithm>
#include <cmath>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

/// Time until a new zero, or the end of a movement, also shows in the positions.
constexpr std::chrono::milliseconds kDriveSettling{5};
/// Exchanges until a report is newer than a command: one until it is sent, on CAN one more behind a target and one
/// until SYNC, and the answer.
constexpr int kUntilReported = 4;

}  // namespace

/// The caller has checked that the drive can change to the mode.
void SingleAxis::start_by_drive(std::uint64_t id, AxisCommand command, cia402::Mode mode) noexcept {
  mode_change_.return_to = axis_->mode();
  static_cast<void>(axis_->set_mode(mode));
  drive_.command = command;
  drive_.request = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  enter(ByDrive::kEntering);
}

void SingleAxis::enter(ByDrive phase) noexcept {
  drive_.phase = phase;
  drive_.since = cycle_;
}

std::chrono::nanoseconds SingleAxis::time_since(std::int64_t cycle) const noexcept {
  return (cycle_ - cycle) * settings_.period;
}

/// Stops the drive: clearing the start bit ends homing, halt ends any other movement; the drive brakes.
void SingleAxis::interrupt_drive() noexcept {
  if (drive_.phase == ByDrive::kNone) return;
  finish(drive_.request, drive_.phase == ByDrive::kLeaving ? RequestPhase::kDone : RequestPhase::kAborted);
  finish(drive_.next, RequestPhase::kAborted);
  // A rotor that the field has taken over swings into its load angle, so it must come to rest first.
  const bool by_field = axis_->inputs().mode == static_cast<std::int8_t>(cia402::Mode::kVelocity);
  if (drive_.phase == ByDrive::kEntering && !by_field) return leave_drive_mode();
  if (drive_.phase == ByDrive::kInterrupted || drive_.phase == ByDrive::kLeaving) return;
  homes() ? axis_->drive().end_request() : axis_->drive().halt();
  drive_.still_since = cycle_;
  drive_.still_place = axis_->inputs().position;
  enter(ByDrive::kInterrupted);
}

void SingleAxis::advance_by_drive() noexcept {
  if (drive_moves()) stay_at(axis_->inputs().position);
  switch (drive_.phase) {
    case ByDrive::kNone:
      break;
    case ByDrive::kEntering:
      if (axis_->mode_ready()) return homes() ? start_homing() : start_profile();
      if (exceeded(drive_.since, settings_.mode_timeout)) {
        finish(drive_.request, RequestPhase::kError, AxisError::kModeTimeout);
        drop_waiting(AxisError::kModeTimeout);
        leave_drive_mode();
      }
      break;
    case ByDrive::kRunning:
      return homes() ? judge_homing() : judge_profile();
    case ByDrive::kAttained:
      if (time_since(drive_.since) >= kDriveSettling && watch_.steady()) take_new_zero();
      break;
    case ByDrive::kInterrupted:
      watch_interruption();
      break;
    case ByDrive::kLeaving:
      if (axis_->mode_ready()) return end_by_drive();
      if (exceeded(drive_.since, settings_.mode_timeout)) fail(AxisError::kModeTimeout);
      break;
  }
}

/// Whether the rotor still moves. In velocity mode a drive reports standstill when its field stands, but the rotor
/// swings on, and setpoints could not hold it yet.
bool SingleAxis::swings() noexcept {
  if (drive_.command != AxisCommand::kDriveRun) return false;
  constexpr double kStopsIn = 1e-4;  // s; the remaining velocity can be stopped in this time within the limits
  constexpr double kNoise = 4.0;     // increments
  const auto& config = axis_->config();
  const double slow = kStopsIn * config.limits.max_acceleration;
  const double most =
      std::max(slow * std::chrono::duration<double>(kDriveSettling).count(), kNoise / config.increments_per_unit);
  const double position = axis_->inputs().position;
  if (std::abs(position - drive_.still_place) <= most) return false;
  drive_.still_place = position;
  return true;
}

/// Waits until the drive has reported standstill for a while: its first report may be older than the end of the
/// movement. A drive that stays in profile position would go on to its target when halt is cleared (CiA 402-2), so it
/// gets the place where it stands as its next one.
void SingleAxis::watch_interruption() noexcept {
  if (swings() || !axis_->drive().stands_still() || !exchange_.good) drive_.still_since = cycle_;
  const auto settling = std::max<std::chrono::nanoseconds>(kDriveSettling, kUntilReported * settings_.period);
  if (time_since(drive_.still_since) >= settling) {
    const bool keeps_target =
        positions_by_drive(drive_.command) && mode_change_.return_to == cia402::Mode::kProfilePosition;
    if (!keeps_target) return leave_drive_mode();
    drive_.target = {axis_->inputs().position, 0.0, 0.0};
    return start_profile();
  }
  if (exceeded(drive_.since, settings_.quick_stop_time))
    fail(homes() ? AxisError::kHomingTimeout : AxisError::kTargetTimeout);
}

/// Returns the drive to setpoints, which start at the actual position. Halt is cleared only then: in its own mode the
/// drive would continue its movement.
void SingleAxis::leave_drive_mode() noexcept {
  if (!axis_->set_mode(*mode_change_.return_to)) return fail(AxisError::kMode);
  enter(ByDrive::kLeaving);
}

void SingleAxis::end_by_drive() noexcept {
  drive_.phase = ByDrive::kNone;
  axis_->drive().end_request();
  axis_->drive().profile().set_target(0.0);
  mode_change_.return_to.reset();
  if (state_ != PlcopenState::kStopping && !active_) state_ = PlcopenState::kStandstill;
  finish(drive_.request, RequestPhase::kDone);
  // A motion or a switch-off has waited for the drive.
  if (active_) return replan();
  if (power_.phase == Power::kResting && !plan_rest()) fail(AxisError::kNotFinite);
  // This positioning was requested after the drive had reached the previous target.
  if (!waiting_.empty() && positions_by_drive(waiting_.front().request.command)) begin_profile(waiting_.pop());
}

/// The drive has lost its power, or stops on its own; its mode is restored when it is off.
void SingleAxis::drop_by_drive(AxisError error) noexcept {
  if (drive_.phase == ByDrive::kNone) return;
  finish(drive_.request, RequestPhase::kError, error);
  finish(drive_.next, RequestPhase::kAborted, error);
  axis_->drive().end_request();
  axis_->drive().profile().set_target(0.0);
  drive_.phase = ByDrive::kNone;
}

}  // namespace driveline::motion
