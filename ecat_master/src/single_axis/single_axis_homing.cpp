// Homing in the drive of a single axis, and the way back to its cyclic mode.
#include "driveline/ecat_master/single_axis/single_axis.hpp"

namespace driveline::ecat_master {
namespace {

/// Until a new zero and the end of the movement have been seen in the positions, too.
constexpr std::chrono::milliseconds kHomeSettling{5};

}  // namespace

void SingleAxis::take_home(std::uint64_t id) noexcept {
  const auto before = axis_->mode();
  if (!axis_->supports(cia402::Mode::kHoming)) return finish(id, RequestPhase::kError, AxisError::kNoSuchMode);
  if (changing_mode_ || !axis_->set_mode(cia402::Mode::kHoming))
    return finish(id, RequestPhase::kError, AxisError::kMode);
  return_mode_ = before;
  home_request_ = id;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  state_ = PlcopenState::kHoming;
  enter(Homing::kEntering);
}

void SingleAxis::enter(Homing homing) noexcept {
  homing_ = homing;
  homing_since_ = cycle_;
}

std::chrono::nanoseconds SingleAxis::homing_for() const noexcept {
  return (cycle_ - homing_since_) * settings_.period;
}

/// From here on the drive moves as it likes.
void SingleAxis::start_homing() noexcept {
  handshake_.start(axis_->inputs().status_word);
  axis_->set_command_bits(cia402::command_bit::kHomingStart);
  enter(Homing::kRunning);
}

/// Taking the start bit back ends homing; the drive brakes.
void SingleAxis::interrupt_homing() noexcept {
  if (homing_ == Homing::kNone) return;
  finish(home_request_, RequestPhase::kAborted);
  if (homing_ == Homing::kEntering) return leave_homing();
  if (homing_ == Homing::kInterrupted || homing_ == Homing::kLeaving) return;
  axis_->set_command_bits(0);
  still_since_ = cycle_;
  enter(Homing::kInterrupted);
}

void SingleAxis::advance_homing() noexcept {
  if (drive_moves()) stay_at(axis_->inputs().position);
  switch (homing_) {
    case Homing::kNone:
      break;
    case Homing::kEntering:
      if (axis_->mode_ready()) return start_homing();
      if (exceeded(homing_since_, settings_.mode_timeout)) {
        finish(home_request_, RequestPhase::kError, AxisError::kModeTimeout);
        leave_homing();
      }
      break;
    case Homing::kRunning:
      return judge_homing();
    case Homing::kAttained:
      if (homing_for() >= kHomeSettling && watch_.steady()) take_new_zero();
      break;
    case Homing::kInterrupted:
      watch_interruption();
      break;
    case Homing::kLeaving:
      if (axis_->mode_ready()) return end_homing();
      if (exceeded(homing_since_, settings_.mode_timeout)) fail(AxisError::kModeTimeout);
      break;
  }
}

void SingleAxis::judge_homing() noexcept {
  if (exchanged_) {
    const auto state = handshake_.judge(axis_->inputs().status_word, homing_for());
    if (state == HomingHandshake::State::kFailed) return fail(AxisError::kHoming);
    if (state == HomingHandshake::State::kAttained) return enter(Homing::kAttained);
  }
  if (exceeded(homing_since_, settings_.homing_timeout)) fail(AxisError::kHomingTimeout);
}

bool SingleAxis::homing_has_failed() noexcept {
  return homing_ == Homing::kRunning &&
         handshake_.judge(axis_->inputs().status_word, homing_for()) == HomingHandshake::State::kFailed;
}

/// It stands when the drive has said so for a while: what it says first may be older than the end of the start bit.
void SingleAxis::watch_interruption() noexcept {
  const bool stands = (axis_->inputs().status_word & cia402::status_bit::kTargetReached) != 0;
  if (!stands) still_since_ = cycle_;
  if ((cycle_ - still_since_) * settings_.period >= kHomeSettling) return leave_homing();
  if (exceeded(homing_since_, settings_.quick_stop_time)) fail(AxisError::kHomingTimeout);
}

/// What was called a position before has no meaning any more.
void SingleAxis::take_new_zero() noexcept {
  axis_->set_command_bits(0);
  axis_->recount();
  watch_.forget();
  offset_ = 0.0;
  stay_at(axis_->inputs().position);
  leave_homing();
}

/// The drive follows setpoints again, which begin where the axis is.
void SingleAxis::leave_homing() noexcept {
  if (!axis_->set_mode(*return_mode_)) return fail(AxisError::kMode);
  enter(Homing::kLeaving);
}

void SingleAxis::end_homing() noexcept {
  homing_ = Homing::kNone;
  return_mode_.reset();
  supply_.set_mode(axis_->mode());
  if (state_ == PlcopenState::kHoming) state_ = PlcopenState::kStandstill;
  finish(home_request_, RequestPhase::kDone);
  // A stop, or being switched off, has waited for it.
  if (active_) return replan();
  if (power_ == Power::kResting && !plan_rest()) fail(AxisError::kNotFinite);
}

/// The drive has lost its power, or stops by itself: its mode comes back when it is off.
void SingleAxis::drop_homing(AxisError error) noexcept {
  if (homing_ == Homing::kNone) return;
  finish(home_request_, RequestPhase::kError, error);
  axis_->set_command_bits(0);
  homing_ = Homing::kNone;
}

}  // namespace driveline::ecat_master
