// States and power of a single axis.
#include "driveline/motion/single_axis/single_axis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace driveline::motion {
namespace {

/// A fault reset needs one cycle with bit 7 set and one with it cleared; several of each tolerate a lost frame.
constexpr std::int64_t kResetCycles = 4;

double seconds_of(std::chrono::nanoseconds time) noexcept {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

SingleAxis::SingleAxis(Axis& axis, RequestTable& table, const Settings& settings)
    : axis_(&axis),
      table_(&table),
      settings_(settings),
      period_s_(seconds_of(settings.period)),
      watch_(axis.config(), settings.period),
      following_watch_(axis.config(), settings.period),
      coast_(axis.config(), period_s_),
      supply_(axis.config(), period_s_, axis.divider()),
      exchange_{
          LostLimit{settings.bad_cycle_limit, settings.bad_time_limit}.exchanges_of(axis.divider(), settings.period)} {}

void SingleAxis::read_inputs(std::span<const std::byte> image, bool valid, bool operational, bool fresh,
                             std::chrono::nanoseconds late) noexcept {
  exchange_.good = valid && fresh;
  if (fresh) {
    exchange_.last_good = valid;
    exchange_.bad = valid ? 0 : exchange_.bad + 1;
  }
  // Single bad exchanges are bridged with the inputs of the last good one.
  if (valid || lost()) axis_->read_inputs(image, valid, fresh, late);
  if (valid && !operational) axis_->set_unavailable();
  // A bus may know that a drive took its outputs though the answer is missing.
  supply_.set_reached(operational, fresh);
}

void SingleAxis::begin_cycle(std::int64_t cycle, std::chrono::nanoseconds took) noexcept {
  cycle_ = cycle;
  supply_.note(setpoint_, axis_->mode_in_force());
  judge_position(took);
  watch();
}

void SingleAxis::enter(Power power) noexcept {
  power_.phase = power;
  power_.since = cycle_;
  power_.cycles_at_rest = 0;
}

bool SingleAxis::exceeded(std::int64_t since, std::chrono::nanoseconds limit) const noexcept {
  return static_cast<double>(cycle_ - since) * period_s_ > seconds_of(limit);
}

/// Whether the drive has no power on its motor.
bool SingleAxis::off() const noexcept {
  using snapshot::AxisState;
  const auto state = axis_->inputs().state;
  return state != AxisState::kOperationEnabled && state != AxisState::kQuickStopActive &&
         state != AxisState::kSwitchedOn && state != AxisState::kFaultReactionActive;
}

/// Checks the actual position before the inputs of this cycle are used. With an implausible position the axis continues
/// without the position loop of the master, from this cycle on.
void SingleAxis::judge_position(std::chrono::nanoseconds took) noexcept {
  if (axis_->inputs().state == snapshot::AxisState::kUnavailable) return forget_place();
  if (!exchange_.good) return axis_->coast_on(period_s_);
  const bool holds = !drive_moves() && axis_->config().mode != cia402::Mode::kProfileVelocity;
  const bool driven = axis_->enabled() && (powered() || power_.phase == Power::kEnabling) && holds;
  const auto finding = watch_.judge(cycle_, axis_->inputs().position, setpoint_, driven, took);
  coast_.update(watch_.held(), axis_->inputs().velocity);
  axis_->hold_at(watch_.held(), coast_.velocity());
  if (finding.kind == PositionFinding::Kind::kNewPlace) {
    setpoint_ = {watch_.held(), 0.0, 0.0};
    rest();
  }
  if (finding && torque_.phase == Torque::kLed) return fail(AxisError::kPosition);
  if (finding && state_ != PlcopenState::kErrorStop) stop_for_position();
}

/// The actual position is unknown from now on.
void SingleAxis::forget_place() noexcept {
  watch_.forget();
  coast_.forget();
}

void SingleAxis::stop_for_position() noexcept {
  // The velocity that the loop added is braked together with that of the setpoint.
  setpoint_.velocity += axis_->disable_position_loop();
  stop_by_ramp(AxisError::kPosition);
}

void SingleAxis::stop_with_partner(bool by_ramp) noexcept {
  by_ramp ? stop_by_ramp(AxisError::kGantryPartner) : fail(AxisError::kGantryPartner);
}

void SingleAxis::stop_by_ramp(AxisError error) noexcept {
  const bool was_powered = powered();
  const auto from = setpoint_;
  fail(error);
  if (!was_powered) return enter(Power::kDisabling);
  generator_.start_from(from);
  if (plan_rest()) enter(Power::kResting);
}

void SingleAxis::watch() noexcept {
  switch (power_.phase) {
    case Power::kOff:
      // A drive with a fault while it is off has to be reset before it can be enabled.
      if (state_ == PlcopenState::kDisabled && axis_->fault()) fail(AxisError::kFault);
      break;
    case Power::kEnabling:
      watch_enabling();
      break;
    case Power::kOn:
    case Power::kResting:
      watch_power();
      break;
    case Power::kQuickStop:
    case Power::kDisabling:
      break;
  }
}

void SingleAxis::watch_enabling() noexcept {
  if (axis_->reports_fault()) return fail(AxisError::kFault);
  if (exceeded(power_.since, settings_.enable_timeout))
    fail(watch_.unsteady() ? AxisError::kPosition : AxisError::kEnableTimeout);
}

void SingleAxis::watch_power() noexcept {
  if (lost() || too_long(0)) return fail(AxisError::kLost);
  if (axis_->fault() || axis_->reports_fault())
    return fail(homing_has_failed() ? AxisError::kHoming : AxisError::kFault);
  if (!axis_->enabled()) return fail(AxisError::kLost);
  const bool follows = state_ != PlcopenState::kErrorStop && torque_.phase == Torque::kNone && !drive_moves();
  if (following_watch_.judge(cycle_, axis_->following_error(), follows)) stop_by_ramp(AxisError::kFollowingError);
}

/// Ends the motion with an error; a drive with power stops by its own quick stop and is switched off.
void SingleAxis::fail(AxisError error) noexcept {
  // The first error counts; more may follow until standstill.
  if (state_ != PlcopenState::kErrorStop) {
    error_ = error;
    error_code_ = axis_->inputs().error_code;
  }
  state_ = PlcopenState::kErrorStop;
  drop_by_drive(error);
  torque_.phase = Torque::kNone;
  finish_move(RequestPhase::kError, error);
  drop_waiting(error);
  finish(power_.request, RequestPhase::kError, error);
  end_probe(RequestPhase::kError, error);
  if (power_.phase != Power::kOff && power_.phase != Power::kDisabling) enter(Power::kQuickStop);
}

void SingleAxis::advance(const trajectory::AxisSetpoint* fed, bool waits) noexcept {
  advance_reset();
  advance_mode();
  advance_probe();
  feed_.held_up = waits ? feed_.held_up + 1 : 0;
  if (powered()) return advance_motion(fed, waits);
  advance_powerless();
}

/// Handles the states in which the drive follows no setpoints.
void SingleAxis::advance_powerless() noexcept {
  restore_mode();
  // An axis that is already enabled holds the position at which it was enabled.
  if (!axis_->stays_on()) setpoint_ = axis_->held();
  switch (power_.phase) {
    case Power::kEnabling:
      // Brake a coasting axis at once; an axis at standstill waits for its brake.
      if (!axis_->ready() && !(axis_->stays_on() && std::abs(setpoint_.velocity) > 0.0)) break;
      begin_powered();
      break;
    case Power::kQuickStop:
      // A drive that stays in Quick stop active (605Ah = 5..8) is switched off once it has had time to stop. So is a
      // drive without valid inputs, which is commanded to stop until then.
      if (off() && axis_->inputs().state != snapshot::AxisState::kUnavailable) {
        enter(Power::kOff);
        finish(power_.request, RequestPhase::kDone);
      } else if (exceeded(power_.since, settings_.quick_stop_time)) {
        enter(Power::kDisabling);
      }
      break;
    case Power::kDisabling:
      if (!off()) break;
      enter(Power::kOff);
      if (state_ != PlcopenState::kErrorStop) state_ = PlcopenState::kDisabled;
      finish(power_.request, RequestPhase::kDone);
      break;
    default:
      break;
  }
}

/// Starts the setpoints of an axis that has got power; a coasting axis is braked.
void SingleAxis::begin_powered() noexcept {
  enter(Power::kOn);
  if (std::abs(setpoint_.velocity) > 0.0) {
    supply_.start_from(setpoint_);
    setpoint_.position += setpoint_.velocity * period_s_;
    step_velocity_ = setpoint_.velocity;
    last_target_ = setpoint_.position;
    beside_ = false;
    generator_.start_from(setpoint_);
    begin_move({});
  } else {
    rest();
    state_ = PlcopenState::kStandstill;
  }
  finish(power_.request, RequestPhase::kDone);
}

/// Leaves ErrorStop when the drive has come to rest and reports no fault.
void SingleAxis::advance_reset() noexcept {
  if (reset_.request == 0 || power_.phase != Power::kOff) return;
  const bool available = axis_->inputs().state != snapshot::AxisState::kUnavailable;
  if (available && !axis_->reports_fault()) {
    state_ = PlcopenState::kDisabled;
    error_ = AxisError::kNone;
    error_code_ = 0;
    return finish(reset_.request, RequestPhase::kDone);
  }
  if (exceeded(reset_.since, settings_.reset_timeout))
    finish(reset_.request, RequestPhase::kError, AxisError::kResetTimeout);
}

/// Whether a mode change, or the return to the setpoints, needs part of the acceleration of the axis.
bool SingleAxis::eases() const noexcept {
  return mode_change_.under_way || torque_.phase == Torque::kEntering || axis_->returning();
}

void SingleAxis::advance_mode() noexcept {
  if (mode_change_.under_way) judge_mode();
  const bool eased = mode_change_.eased;
  mode_change_.eased = eases();
  // The motion has the whole acceleration of the axis again.
  if (eased && !mode_change_.eased && powered() && drive_.phase == ByDrive::kNone) replan();
}

/// Ends a mode change; a drive that does not change in time is set back to its previous mode.
void SingleAxis::judge_mode() noexcept {
  if (axis_->mode_ready() || !powered()) {
    mode_change_.under_way = false;
    return finish(mode_change_.request, RequestPhase::kDone);
  }
  if (!exceeded(mode_change_.since, settings_.mode_timeout)) return;
  mode_change_.under_way = false;
  const bool back = axis_->set_mode(mode_change_.before);
  finish(mode_change_.request, RequestPhase::kError, back ? AxisError::kModeTimeout : AxisError::kMode);
}

/// A drive that failed in another mode starts again in the mode of its setpoints.
void SingleAxis::restore_mode() noexcept {
  if (!mode_change_.return_to || axis_->enabled()) return;
  static_cast<void>(axis_->set_mode(*mode_change_.return_to));
  mode_change_.return_to.reset();
}

cia402::Goal SingleAxis::goal() const noexcept {
  using cia402::Goal;
  switch (power_.phase) {
    case Power::kOn:
    case Power::kResting:
      return Goal::kEnabled;
    case Power::kEnabling:
      // Wait for a steady position, because the axis holds the position at which it is enabled.
      return coast_.goal(*axis_, watch_.steady(), exchange_.last_good);
    case Power::kQuickStop:
      return Goal::kQuickStop;
    case Power::kOff:
    case Power::kDisabling:
      break;
  }
  return Goal::kDisabled;
}

void SingleAxis::write_outputs(std::span<std::byte> image) noexcept {
  const bool resetting =
      reset_.request != 0 && power_.phase == Power::kOff && cycle_ % (2 * kResetCycles) < kResetCycles;
  const bool by_generator = drive_moves() && !homes();
  axis_->write_outputs(image, goal(), resetting, by_generator ? drive_.target : setpoint_);
}

AbsenceEffect SingleAxis::resume(std::int64_t cycle, std::int64_t missed) noexcept {
  cycle_ = cycle;
  if (!powered()) {
    // A coasting axis kept moving: enable it only after its position was read again, else extrapolate its motion.
    exchange_.last_good = false;
    axis_->coast_on(static_cast<double>(missed) * period_s_);
    if (too_long(missed) && coast_.coasts()) forget_place();
    if (!axis_->stays_on()) setpoint_ = axis_->held();
    return AbsenceEffect::kNone;
  }
  if (too_long(missed)) {
    fail(AxisError::kMasterAway);
    return AbsenceEffect::kStopped;
  }
  supply_.skip(missed, axis_->mode_in_force());
  axis_->skip(missed);
  if (drive_.phase == ByDrive::kNone && torque_.phase != Torque::kLed) bridge();
  return AbsenceEffect::kBridged;
}

}  // namespace driveline::motion
