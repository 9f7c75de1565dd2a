#include "driveline/motion/single_axis/gantry.hpp"

#include <cmath>

namespace driveline::motion {
namespace {

/// Rise time of the acceleration when a follower is squared, s; it defines the jerk.
constexpr double kRiseS = 0.01;
/// Share of the warning threshold below which a warning ends.
constexpr double kWarningEnds = 0.9;

AxisRequest plain(AxisCommand command) noexcept {
  AxisRequest request;
  request.command = command;
  return request;
}

bool failed(const SingleAxis& axis) noexcept {
  return axis.state() == PlcopenState::kErrorStop;
}

/// Whether the command would move each axis of a pair independently: by its drive, or by a torque.
bool parts(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kHome:
    case AxisCommand::kSetMode:
    case AxisCommand::kTorque:
    case AxisCommand::kDriveMoveAbsolute:
    case AxisCommand::kDriveMoveRelative:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return true;
    default:
      return false;
  }
}

/// Whether the command is refused while the pair is being homed.
bool disturbs_homing(AxisCommand command) noexcept {
  return !stops_or_releases(command) && command != AxisCommand::kSetOverride;
}

}  // namespace

Gantry::Gantry(SingleAxis& leader, SingleAxis& follower, RequestTable& table, const GantrySettings& settings,
               double period_s)
    : leader_(leader),
      follower_(follower),
      table_(table),
      settings_(settings),
      period_s_(period_s),
      squaring_(trajectory::ProfileLimits::symmetric(settings.square_velocity, settings.square_acceleration,
                                                     settings.square_acceleration / kRiseS)) {
  if (!settings_.when_homed) square_at_ = settings_.offset;
  follower_.set_in_formation();
}

void Gantry::finish(std::uint64_t& id, RequestPhase phase, AxisError error) noexcept {
  if (id != 0) table_.set(id, {phase, error});
  id = 0;
}

std::uint64_t Gantry::ask(SingleAxis& axis, const AxisRequest& request) noexcept {
  const auto id = table_.add();
  axis.take(id, request);
  return id;
}

void Gantry::ask_both(Pair& pair, const AxisRequest& request) noexcept {
  pair = {ask(leader_, request), ask(follower_, request)};
}

bool Gantry::over(const Pair& pair) const noexcept {
  return table_.report(pair.leader).over() && table_.report(pair.follower).over();
}

AxisError Gantry::error_of(const Pair& pair) const noexcept {
  const auto leader = table_.report(pair.leader).error;
  return leader != AxisError::kNone ? leader : table_.report(pair.follower).error;
}

double Gantry::difference() const noexcept {
  return follower_.axis().inputs().position - leader_.axis().inputs().position;
}

AxisError Gantry::refusal(const AxisRequest& request) const noexcept {
  const auto command = request.command;
  if (parts(command)) return AxisError::kGantry;
  if (command == AxisCommand::kPower || command == AxisCommand::kReset) return AxisError::kNone;
  if (failed_ && command != AxisCommand::kSetOverride) return AxisError::kErrorStop;
  if (homing_ != Homing::kNone && disturbs_homing(command)) return AxisError::kNotAtRest;
  const bool anytime = command == AxisCommand::kSetOverride || command == AxisCommand::kSetPosition ||
                       command == AxisCommand::kTouchProbe || command == AxisCommand::kAbortTrigger;
  return anytime || phase_ == Phase::kFormed ? AxisError::kNone : AxisError::kNotEnabled;
}

void Gantry::take(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept {
  // A stop is accepted on either axis.
  if (axis == settings_.follower && !stops_or_releases(request.command))
    return finish(id, RequestPhase::kError, AxisError::kGantryFollower);
  if (const auto error = refusal(request); error != AxisError::kNone) return finish(id, RequestPhase::kError, error);
  switch (request.command) {
    case AxisCommand::kPower:
      return take_power(id, request);
    case AxisCommand::kReset:
      finish(reset_request_, RequestPhase::kAborted);
      reset_request_ = id;
      table_.set(id, {RequestPhase::kActive, AxisError::kNone});
      return ask_both(resets_, request);
    case AxisCommand::kHomeByProbe:
      return take_homing(id, request);
    default:
      if (homing_ != Homing::kNone && request.command != AxisCommand::kSetOverride) end_homing(RequestPhase::kAborted);
      return leader_.take(id, request);
  }
}

/// Enables or disables the pair. It is not enabled with too much skew, because the beam would be bent.
void Gantry::take_power(std::uint64_t id, const AxisRequest& request) noexcept {
  finish(power_request_, RequestPhase::kAborted);
  if (!request.on) {
    power_request_ = id;
    table_.set(id, {RequestPhase::kActive, AxisError::kNone});
    if (homing_ != Homing::kNone) end_homing(RequestPhase::kAborted);
    powers_ = {ask(leader_, request), 0};
    if (phase_ == Phase::kFormed) {
      phase_ = Phase::kDissolving;
    } else {
      powers_.follower = ask(follower_, request);
      phase_ = Phase::kApart;
    }
    return;
  }
  if (failed_) return finish(id, RequestPhase::kError, AxisError::kErrorStop);
  if (phase_ == Phase::kDissolving) {
    // The pair is coming to rest: keep the power, and halt.
    leader_.take(id, request);
    phase_ = Phase::kFormed;
    return;
  }
  if (phase_ == Phase::kFormed) return finish(id, RequestPhase::kDone);
  if (square_at_ && !settings_.square_when_enabled) {
    const double skew = difference() - *square_at_;
    if (std::abs(skew) > settings_.skew_limit) {
      stopped_at_ = skew;
      // Publish the skew before the error, so that a reader of the error finds it.
      publish();
      return finish(id, RequestPhase::kError, AxisError::kSkew);
    }
  }
  power_request_ = id;
  table_.set(id, {RequestPhase::kActive, AxisError::kNone});
  worst_skew_ = 0.0;
  ask_both(powers_, request);
  phase_ = Phase::kJoining;
}

void Gantry::watch() noexcept {
  watch_failures();
  watch_reset();
  watch_power();
  watch_skew();
  // In a square pair the same position has the same name on both axes.
  follower_.set_position_offset(leader_.position_offset() - square_at_.value_or(offset_.state().position));
  publish();
}

/// The axis that failed first determines the stop: by a ramp, common to both, or by the drives.
void Gantry::watch_failures() noexcept {
  const bool leads = failed(leader_);
  const bool goes = failed(follower_);
  if (!leads && !goes) {
    failed_ = false;
    return;
  }
  if (failed_) return;
  failed_ = true;
  const auto error = leads ? leader_.error() : follower_.error();
  if (!leads) leader_.stop_with_partner(follower_.comes_to_rest());
  if (!goes) follower_.stop_with_partner(leader_.comes_to_rest());
  phase_ = Phase::kApart;
  end_homing(RequestPhase::kError, error);
  finish(power_request_, RequestPhase::kError, error);
}

void Gantry::watch_reset() noexcept {
  if (reset_request_ == 0 || !over(resets_)) return;
  const auto error = error_of(resets_);
  finish(reset_request_, error == AxisError::kNone ? RequestPhase::kDone : RequestPhase::kError, error);
}

void Gantry::watch_power() noexcept {
  if (phase_ == Phase::kJoining) {
    if (!over(powers_)) return;
    const bool stand = leader_.state() == PlcopenState::kStandstill && follower_.state() == PlcopenState::kStandstill;
    if (stand) form();
    return;
  }
  if (phase_ == Phase::kDissolving && leader_.at_rest_without_setpoints()) dissolve();
  if (phase_ == Phase::kApart && power_request_ != 0 && over(powers_)) finish(power_request_, RequestPhase::kDone);
}

/// Forms the pair at the present positions; from here on both axes move as one.
void Gantry::form() noexcept {
  offset_.start_from({follower_.setpoint().position - leader_.setpoint().position, 0.0, 0.0});
  static_cast<void>(ask(follower_, plain(AxisCommand::kFollow)));
  phase_ = Phase::kFormed;
  square();
  finish(power_request_, RequestPhase::kDone);
}

void Gantry::dissolve() noexcept {
  auto off = plain(AxisCommand::kPower);
  off.on = false;
  powers_.follower = ask(follower_, off);
  phase_ = Phase::kApart;
}

void Gantry::square() noexcept {
  // From a state within its own limits, planning always succeeds.
  if (square_at_) static_cast<void>(offset_.to_position({*square_at_, 0.0, 0.0}, squaring_));
}

/// Compares positions of the same cycle.
void Gantry::watch_skew() noexcept {
  if (!leader_.exchanged() || !follower_.exchanged()) return;
  const bool together = phase_ == Phase::kFormed || phase_ == Phase::kDissolving;
  const double in_force = together ? offset_.state().position : square_at_.value_or(difference());
  skew_ = difference() - in_force;
  if (!together) {
    warned_ = false;
    return;
  }
  if (std::abs(skew_) > std::abs(worst_skew_)) worst_skew_ = skew_;
  warned_ = std::abs(skew_) > (warned_ ? kWarningEnds : 1.0) * settings_.skew_warning;
  // The pair has separated if the follower has stopped following, at the end of its range.
  const bool parted = !follower_.follows();
  if (std::abs(skew_) <= settings_.skew_limit && !parted) return;
  const auto error = parted ? AxisError::kGantryPartner : AxisError::kSkew;
  stopped_at_ = skew_;
  failed_ = true;
  publish();
  leader_.stop_by_ramp(error);
  follower_.stop_by_ramp(error);
  phase_ = Phase::kApart;
  end_homing(RequestPhase::kError, error);
  finish(power_request_, RequestPhase::kError, error);
}

void Gantry::advance() noexcept {
  advance_homing();
  if (phase_ != Phase::kFormed && phase_ != Phase::kDissolving) return follower_.advance(nullptr);
  const auto& beside = offset_.advance(period_s_);
  auto setpoint = leader_.setpoint();
  setpoint.position += beside.position + follower_.position_offset();
  setpoint.velocity += beside.velocity;
  setpoint.acceleration += beside.acceleration;
  setpoint.torque = {};
  follower_.advance(&setpoint);
}

void Gantry::publish() noexcept {
  const bool together = phase_ == Phase::kFormed || phase_ == Phase::kDissolving;
  formed_shared_.store(together, std::memory_order_relaxed);
  squaring_shared_.store(together && !offset_.finished(), std::memory_order_relaxed);
  warned_shared_.store(warned_, std::memory_order_relaxed);
  skew_shared_.store(skew_, std::memory_order_relaxed);
  worst_shared_.store(worst_skew_, std::memory_order_relaxed);
  stopped_shared_.store(stopped_at_, std::memory_order_relaxed);
}

GantryReport Gantry::report() const noexcept {
  GantryReport report;
  report.formed = formed_shared_.load(std::memory_order_relaxed);
  report.squaring = squaring_shared_.load(std::memory_order_relaxed);
  report.warned = warned_shared_.load(std::memory_order_relaxed);
  report.skew = skew_shared_.load(std::memory_order_relaxed);
  report.worst_skew = worst_shared_.load(std::memory_order_relaxed);
  report.stopped_at = stopped_shared_.load(std::memory_order_relaxed);
  return report;
}

}  // namespace driveline::motion
