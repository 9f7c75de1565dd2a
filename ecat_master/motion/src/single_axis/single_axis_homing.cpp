// Homing of a single axis by its drive.
#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {

void SingleAxis::take_home(std::uint64_t id) noexcept {
  if (!axis_->supports(cia402::Mode::kHoming)) return finish(id, RequestPhase::kError, AxisError::kNoSuchMode);
  if (!mode_may_change() || !axis_->can_change(cia402::Mode::kHoming))
    return finish(id, RequestPhase::kError, AxisError::kMode);
  state_ = PlcopenState::kHoming;
  start_by_drive(id, AxisCommand::kHome, cia402::Mode::kHoming);
}

/// From here on the drive controls the motion.
void SingleAxis::start_homing() noexcept {
  axis_->drive().begin_homing();
  homing_.homed = snapshot::AxisHomed::kNo;
  enter(ByDrive::kRunning);
}

void SingleAxis::judge_homing() noexcept {
  if (exchange_.good) {
    const auto state = axis_->drive().homing_progress(time_since(drive_.since));
    if (state == DriveLink::HomingProgress::kFailed) return fail(AxisError::kHoming);
    if (state == DriveLink::HomingProgress::kAttained) return enter(ByDrive::kAttained);
  }
  if (exceeded(drive_.since, settings_.homing_timeout)) fail(AxisError::kHomingTimeout);
}

bool SingleAxis::homing_has_failed() noexcept {
  return drive_.phase == ByDrive::kRunning && homes() &&
         axis_->drive().homing_progress(time_since(drive_.since)) == DriveLink::HomingProgress::kFailed;
}

/// Takes over the new zero of the drive; earlier position names are invalid.
void SingleAxis::take_new_zero() noexcept {
  axis_->drive().end_request();
  axis_->recount();
  watch_.forget();
  end_probe(RequestPhase::kAborted, AxisError::kNone);
  offset_ = 0.0;
  homing_.homed = snapshot::AxisHomed::kYes;
  stay_at(axis_->inputs().position);
  leave_drive_mode();
}

}  // namespace driveline::motion
