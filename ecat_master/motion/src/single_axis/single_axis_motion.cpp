// Motions of a single axis.
#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/motion/single_axis/single_axis.hpp"
#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/velocity_profile.hpp"

namespace driveline::motion {
namespace {

using trajectory::AxisSetpoint;

/// Time at rest before an axis is switched off, s.
constexpr double kSettling = 0.01;
/// Share of max_acceleration for motions while a drive changes its mode; the change needs the rest.
constexpr double kShareInChange = 0.6;
constexpr double kALittleMore = 1.0 + 1e-9;
constexpr double kNoJerkLimit = std::numeric_limits<double>::infinity();

double or_else(double value, double otherwise) noexcept {
  return value > 0.0 ? value : otherwise;
}

bool usable(const AxisSetpoint* fed) noexcept {
  return fed != nullptr && std::isfinite(fed->position) && std::isfinite(fed->velocity) &&
         std::isfinite(fed->acceleration);
}

PlcopenState state_of(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kStop:
      return PlcopenState::kStopping;
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kTorque:
      return PlcopenState::kContinuousMotion;
    case AxisCommand::kFollow:
      return PlcopenState::kSynchronizedMotion;
    default:
      return PlcopenState::kDiscreteMotion;
  }
}

}  // namespace

double SingleAxis::velocity_of(const AxisRequest& request) const noexcept {
  return or_else(request.velocity_si, axis_->config().limits.max_velocity);
}

trajectory::ProfileLimits SingleAxis::full_limits() const noexcept {
  const auto& limits = axis_->config().limits;
  return trajectory::ProfileLimits::symmetric(limits.max_velocity, most_acceleration(),
                                              jerk_of({}, generator_.state()));
}

/// Highest acceleration of a motion, rad/s^2 or m/s^2.
double SingleAxis::most_acceleration() const noexcept {
  return (eases() ? kShareInChange : 1.0) * axis_->config().limits.max_acceleration;
}

/// Limits of a motion that starts at `from` in the direction of `way`; acceleration and deceleration may differ.
trajectory::ProfileLimits SingleAxis::limits_of(const AxisRequest& request, double way,
                                                const AxisSetpoint& from) const noexcept {
  auto limits = full_limits();
  const double most = axis_->config().limits.max_velocity;
  const double velocity = std::clamp(velocity_of(request) * override_, 0.0, most);
  const double most_acceleration = limits.max_acceleration;
  const double faster = std::min(or_else(request.acceleration_si, most_acceleration), most_acceleration);
  const double slower = std::min(or_else(request.deceleration_si, faster), most_acceleration);
  limits.max_velocity = velocity;
  limits.min_velocity = -velocity;
  limits.max_acceleration = way >= 0.0 ? faster : slower;
  limits.min_acceleration = way >= 0.0 ? -slower : -faster;
  limits.max_jerk = jerk_of(request, from);
  return limits;
}

/// Jerk limit of a motion. An axis with high acceleration would exceed max_velocity at this jerk; the velocity has
/// precedence.
double SingleAxis::jerk_of(const AxisRequest& request, const AxisSetpoint& now) const noexcept {
  const double asked = or_else(request.jerk_si, axis_->config().max_jerk.value_or(kNoJerkLimit));
  const double most = axis_->config().limits.max_velocity;
  const double room = now.acceleration > 0.0 ? most - now.velocity : most + now.velocity;
  const double needed = 0.5 * now.acceleration * now.acceleration * kALittleMore;
  return asked * room >= needed ? asked : room > 0.0 ? needed / room : kNoJerkLimit;
}

double SingleAxis::target_of(const AxisRequest& request, const AxisSetpoint& from, double last_target) const noexcept {
  switch (request.command) {
    case AxisCommand::kMoveAbsolute:
      return request.direction == MoveDirection::kNone ? request.target_si - offset_ : place_of(request, from);
    case AxisCommand::kMoveAdditive:
      return last_target + request.target_si;
    default:
      return from.position + request.target_si;
  }
}

void SingleAxis::begin_move(const Move& move) noexcept {
  const bool torque = move.request.command == AxisCommand::kTorque;
  // A buffered torque request may meet another mode than the one in which it was accepted.
  if (torque && torque_.phase == Torque::kNone &&
      !(mode_may_change() && axis_->can_change(cia402::Mode::kCyclicTorque))) {
    auto refused = move.id;
    finish(refused, RequestPhase::kError, AxisError::kMode);
    return begin_move({});
  }
  if (!torque) leave_torque();
  active_ = move;
  run_velocity_.reset();
  if (move.request.direction != MoveDirection::kNone) go_from_here();
  active_->target = target_of(move.request, generator_.state(), last_target_);
  if (leads_to_position(move.request.command)) last_target_ = active_->target;
  state_ = state_of(move.request.command);
  if (torque) begin_torque();
  if (move.id != 0) table_->set(move.id, {RequestPhase::kActive, AxisError::kNone});
  replan();
}

/// A new plan starts at the last setpoint, even if a gap has separated it from the previous plan. With a superimposed
/// motion, it starts at the part below that.
void SingleAxis::go_from_here() noexcept {
  const auto& on_top = on_top_.motion.state();
  if (beside_) generator_.start_from({setpoint_.position - on_top.position, step_velocity_ - on_top.velocity, 0.0});
  beside_ = false;
  return_motion_.reset();
  if (on_top_.active) rejoin_from(setpoint_.position, step_velocity_);
}

void SingleAxis::rejoin_from(double position, double velocity) noexcept {
  rejoin_ = {position, velocity, {axis_->config().limits.max_velocity, most_acceleration()}};
}

/// Plans the motion under way from the last setpoint to its aim.
void SingleAxis::replan() noexcept {
  if (!active_) return;
  ++planned_;
  due_ = Due::kNone;
  go_from_here();
  bool planned = true;
  switch (active_->request.command) {
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kHomeByProbe:
      planned = override_ > 0.0 ? plan_position(*active_) : plan_rest();
      break;
    case AxisCommand::kMoveVelocity:
      planned = run_at(velocity_below());
      break;
    case AxisCommand::kTorque:
      planned = torque_.phase == Torque::kLed || plan_on();
      break;
    case AxisCommand::kFollow:
      // A led axis continues at the velocity of its last step, not at the velocity at the end of that step.
      rejoin_from(setpoint_.position, step_velocity_);
      break;
    default:
      planned = plan_rest();
      break;
  }
  if (!planned) fail(AxisError::kNotFinite);
}

/// Velocity of the motion below; the superimposed motion keeps its share of the limit until it is done.
double SingleAxis::velocity_below() noexcept {
  const double limit = axis_->config().limits.max_velocity;
  const double most = on_top_.active ? std::max(limit - on_top_.velocity, 0.0) : limit;
  const double wanted = std::clamp(active_->request.target_si * override_, -limit, limit);
  on_top_.holds_back = std::abs(wanted) > most * kALittleMore;
  return std::clamp(wanted, -most, most);
}

/// Continues at the present velocity.
bool SingleAxis::plan_on() noexcept {
  return generator_.to_velocity(generator_.state().velocity, full_limits());
}

/// Position at which a motion at a velocity ends; none: the axis has no range, or stands.
std::optional<double> SingleAxis::end_of_run(double velocity) const noexcept {
  const auto& range = axis_->config().software_limits;
  if (!range || !(std::abs(velocity) > 0.0)) return std::nullopt;
  return velocity > 0.0 ? range->max : range->min;
}

/// Limits of a motion at a velocity.
trajectory::ProfileLimits SingleAxis::run_limits(const AxisRequest& request, double velocity) const noexcept {
  const auto& from = generator_.state();
  auto limits = limits_of(request, velocity - from.velocity, from);
  if (end_of_run(velocity)) {
    // Braking at the end is not part of reaching the velocity, so both directions use the higher value.
    const double faster = std::max(limits.max_acceleration, -limits.min_acceleration);
    limits.max_velocity = std::abs(velocity);
    limits.min_velocity = -std::abs(velocity);
    limits.max_acceleration = faster;
    limits.min_acceleration = -faster;
    return limits;
  }
  limits.max_velocity = axis_->config().limits.max_velocity;
  limits.min_velocity = -limits.max_velocity;
  return limits;
}

/// Moves at a velocity until stopped, or to the end of the range.
bool SingleAxis::run_at(double velocity) noexcept {
  const auto limits = run_limits(active_->request, velocity);
  const auto end = end_of_run(velocity);
  run_velocity_ = end ? std::optional(velocity) : std::nullopt;
  return end ? generator_.to_position({*end, 0.0, 0.0}, limits) : generator_.to_velocity(velocity, limits);
}

bool SingleAxis::in_range(double position) const noexcept {
  const auto& range = axis_->config().software_limits;
  return !range || (position >= range->min && position <= range->max);
}

/// Why a motion cannot start at the present setpoint: it leaves the range, or it takes longer than a profile may last.
/// Nothing has changed yet, so a refused motion leaves the present one under way.
AxisError SingleAxis::refusal_of_motion(const Move& move) const noexcept {
  const auto& range = axis_->config().software_limits;
  const auto& from = generator_.state();
  switch (move.request.command) {
    case AxisCommand::kMoveVelocity:
      if (range && !(move.request.target_si > 0.0 ? from.position < range->max : from.position > range->min))
        return AxisError::kOutsideRange;
      return velocity_in_time(move.request) ? AxisError::kNone : AxisError::kTooLong;
    case AxisCommand::kStop:
    case AxisCommand::kHalt:
      return trajectory::plan_to_velocity(from, 0.0, 0.0, rest_limits(move.request)) ? AxisError::kNone
                                                                                     : AxisError::kTooLong;
    default:
      break;
  }
  if (!leads_to_position(move.request.command)) return AxisError::kNone;
  const double target = target_of(move.request, from, last_target_);
  if (!in_range(target)) return AxisError::kOutsideRange;
  // An override of zero holds the axis.
  if (!(override_ > 0.0)) return AxisError::kNone;
  const auto way = way_to(target, move.request);
  if (!way) return AxisError::kTooLong;
  // An axis outside the range may return to it.
  if (!range || !in_range(from.position)) return AxisError::kNone;
  return trajectory::fits(*way, *range) ? AxisError::kNone : AxisError::kOutsideRange;
}

/// Profile from the present setpoint to rest at a position; none: it would last too long.
std::optional<trajectory::Profile> SingleAxis::way_to(double target, const AxisRequest& request) const noexcept {
  const auto& from = generator_.state();
  const auto way =
      trajectory::plan_to_position(from, {target, 0.0, 0.0}, limits_of(request, target - from.position, from));
  return way ? std::optional(*way) : std::nullopt;
}

/// Whether a motion at a velocity reaches it, and then the end of the range, in the time that a profile may last.
bool SingleAxis::velocity_in_time(const AxisRequest& request) const noexcept {
  const double most = axis_->config().limits.max_velocity;
  const double velocity = std::clamp(request.target_si * override_, -most, most);
  const auto limits = run_limits(request, velocity);
  const auto& from = generator_.state();
  const auto end = end_of_run(velocity);
  return end ? trajectory::plan_to_position(from, {*end, 0.0, 0.0}, limits).has_value()
             : trajectory::plan_to_velocity(from, velocity, 0.0, limits).has_value();
}

/// Whether the motion under way can be planned again from the present setpoint.
bool SingleAxis::can_continue() const noexcept {
  if (active_->request.command == AxisCommand::kMoveVelocity) return velocity_in_time(active_->request);
  if (!leads_to_position(active_->request.command) || !(override_ > 0.0)) return true;
  return way_to(active_->target, active_->request).has_value();
}

/// Whether the axis can no longer be stopped within the range.
bool SingleAxis::leaves_range(const AxisSetpoint& from) const noexcept {
  const auto& config = axis_->config();
  if (!config.software_limits) return false;
  const double most = config.limits.max_acceleration;
  const double speed = std::abs(from.velocity);
  const double until_braking_s = config.max_jerk ? 2.0 * most / *config.max_jerk : 0.0;
  const double way = speed * (0.5 * speed / most + until_braking_s);
  return from.velocity > 0.0 ? from.position + way > config.software_limits->max
                             : from.velocity < 0.0 && from.position - way < config.software_limits->min;
}

/// Limits of a stop or a halt, which specifies its own deceleration.
trajectory::ProfileLimits SingleAxis::rest_limits(const AxisRequest& request) const noexcept {
  const double most = most_acceleration();
  const double braking = std::min(or_else(request.deceleration_si, most), most);
  return trajectory::ProfileLimits::symmetric(axis_->config().limits.max_velocity, braking,
                                              jerk_of(request, generator_.state()));
}

bool SingleAxis::plan_rest() noexcept {
  go_from_here();
  const bool own = active_ && !leads_to_position(active_->request.command);
  return generator_.to_velocity(0.0, own ? rest_limits(active_->request) : full_limits());
}

bool SingleAxis::plan_position(const Move& move) noexcept {
  const auto& from = generator_.state();
  const auto limits = limits_of(move.request, move.target - from.position, from);
  const auto passage = passage_of(move);
  if (!generator_.to_position({move.target, passage ? passage->velocity : 0.0, 0.0}, limits)) return false;
  if (passage) generator_.go_on_with(passage->way_on);
  return true;
}

/// Computes the setpoint of this cycle. Time does not advance for a setpoint that may not have reached the drive: the
/// motion waits, and the axis returns to it within its limits. The path of several axes waits for each of them.
void SingleAxis::advance_motion(const AxisSetpoint* fed, bool waits) noexcept {
  if (drive_.phase != ByDrive::kNone) return advance_by_drive();
  // In profile velocity a drive at rest holds no position, so it may drift.
  const bool drifts = axis_->config().mode == cia402::Mode::kProfileVelocity;
  if (drifts && !active_ && power_.phase == Power::kOn) return stay_at(axis_->inputs().position);
  if (homing_.search != Search::kNone) advance_search();
  if (torque_.phase == Torque::kEntering) enter_torque();
  if (torque_.phase == Torque::kLed) return advance_torque();
  if (!supply_.reached() || waits) {
    // Other feeds than a path do not wait.
    if (!waits && follows() && usable(fed)) static_cast<void>(rejoin_.step(fed_to(*fed), period_s_));
    return bridge();
  }
  if (beside_ && !return_motion_) {
    const trajectory::AxisLimits limits{axis_->config().limits.max_velocity, most_acceleration()};
    return_motion_.emplace(supply_, limits);
  }
  if (follows()) return follow(fed);
  const bool may_pass = generator_.goes_on();
  const auto target = generator_.advance(period_s_);
  if (may_pass && !generator_.goes_on()) pass_end();
  if (on_top_.active) {
    step_on_top(target);
  } else if (beside_) {
    step_back_to(target);
  } else {
    step_to(target);
  }
  if (active_ && run_velocity_) tell_velocity();
  if (generator_.finished() && !beside_ && torque_.phase == Torque::kNone) arrive();
}

/// Reports the velocity as reached while the axis moves to the end of the range.
void SingleAxis::tell_velocity() noexcept {
  const double missing = *run_velocity_ - generator_.state().velocity;
  if (due_ == Due::kNext || on_top_.holds_back || std::abs(missing) > 1e-9 * std::abs(*run_velocity_)) return;
  tell_reached();
  if (!waiting_.empty()) end_motion();
}

/// A motion that has ended, and was planned anew before the next one had its turn, reports nothing.
void SingleAxis::tell_reached() noexcept {
  if (active_->id != 0) table_->set(active_->id, {RequestPhase::kReached, AxisError::kNone});
}

void SingleAxis::bridge() noexcept {
  setpoint_ = supply_.bridge(feed_.held_up);
  step_velocity_ = setpoint_.velocity;
  beside_ = true;
  return_motion_.reset();
}

/// Moves one step back to `target` after a gap.
void SingleAxis::step_back_to(const AxisSetpoint& target) noexcept {
  step_to(return_motion_->step(target, period_s_, eases()));
  beside_ = !return_motion_->joined();
}

void SingleAxis::step_to(const AxisSetpoint& setpoint) noexcept {
  step_velocity_ = (setpoint.position - setpoint_.position) / period_s_;
  setpoint_ = setpoint;
}

/// Target of an axis that follows a feed, including the superimposed motion.
AxisSetpoint SingleAxis::fed_to(const AxisSetpoint& fed) noexcept {
  return with_on_top({fed.position - offset_, fed.velocity, fed.acceleration});
}

/// Adds the superimposed motion and clamps the sum, or the feed, to the limits of the axis.
AxisSetpoint SingleAxis::with_on_top(const AxisSetpoint& below) noexcept {
  const auto& limits = axis_->config().limits;
  const auto& beside = on_top_.active ? on_top_.motion.advance(period_s_) : on_top_.motion.state();
  return {below.position + beside.position,
          std::clamp(below.velocity + beside.velocity, -limits.max_velocity, limits.max_velocity),
          std::clamp(below.acceleration + beside.acceleration, -limits.max_acceleration, limits.max_acceleration)};
}

/// Moves one step towards a target that may exceed the limits of the axis. After a gap, unless the axis is led by
/// torque, one motion from the last sent setpoint covers both the return and the target.
void SingleAxis::lead_to(const AxisSetpoint& target) noexcept {
  if (beside_ && !supply_.by_torque()) {
    rejoin_from(supply_.sent(), supply_.sent_velocity());
    beside_ = false;
  }
  const auto led = rejoin_.step(target, period_s_);
  beside_ ? step_back_to(led) : step_to(led);
}

void SingleAxis::follow(const AxisSetpoint* fed) noexcept {
  const bool leaves = !feed_.keeps_range && leaves_range({setpoint_.position, step_velocity_, 0.0});
  if (!usable(fed) || leaves) {
    const auto error = leaves ? AxisError::kOutsideRange : AxisError::kFollowing;
    if (fed != nullptr) finish(active_->id, RequestPhase::kError, error);
    active_->request = {};
    drop_superimposed();
    state_ = PlcopenState::kDiscreteMotion;
    replan();
    return step_to(generator_.advance(period_s_));
  }
  lead_to(fed_to(*fed));
  generator_.start_from(setpoint_);
  if (!rejoin_.joined() || beside_) return;
  table_->set(active_->id, {RequestPhase::kReached, AxisError::kNone});
  if (on_top_.active) settle_superimposed();
}

/// Ends the motion whose aim the generator has reached.
void SingleAxis::arrive() noexcept {
  if (power_.phase == Power::kResting) {
    // The drive lags slightly behind its setpoints.
    if (++power_.cycles_at_rest * period_s_ > kSettling) enter(Power::kDisabling);
    return;
  }
  if (!active_ || due_ == Due::kNext) return;
  const auto command = active_->request.command;
  if (run_velocity_) {
    finish_move(RequestPhase::kError, AxisError::kOutsideRange);
    drop_waiting(AxisError::kNone);
    state_ = PlcopenState::kStandstill;
    return;
  }
  if (command == AxisCommand::kMoveVelocity) {
    if (on_top_.holds_back) return;
    tell_reached();
    if (waiting_.empty()) return;
  }
  // An override of zero holds the axis.
  if (leads_to_position(command) && !(override_ > 0.0)) return;
  if (homing_.search != Search::kNone && !arrive_in_search()) return;
  if (command != AxisCommand::kStop) return end_motion();
  // No motion starts after a buffered stop.
  finish_move(RequestPhase::kDone);
  drop_waiting(AxisError::kNone);
}

void SingleAxis::stay_at(double position) noexcept {
  setpoint_ = {position, 0.0, 0.0};
  rest();
}

/// Resets the setpoints to standstill at the present setpoint.
void SingleAxis::rest() noexcept {
  on_top_.active = false;
  on_top_.motion.start_from({});
  generator_.start_from({setpoint_.position, 0.0, 0.0});
  supply_.start_from({setpoint_.position, 0.0, 0.0});
  last_target_ = setpoint_.position;
  step_velocity_ = 0.0;
  beside_ = false;
}

}  // namespace driveline::motion
