#include "driveline/slaves/msd/core/drive_motion.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/msd/core/control_clock.hpp"

namespace driveline::slaves::msd {
namespace {

using Loop = ControllerSetpoint::Loop;

constexpr double kStopShare = 0.7;      ///< stop time constant per speed controller reset time; ours
constexpr double kStopAtLeastS = 2e-3;  ///< minimum of this time constant
constexpr double kSpeedLimitS = 2e-3;   ///< time constant of the approach to the speed limit; ours
constexpr double kSpeedLagS = 1e-3;     ///< maximum lag of the measured speed; ours
/// Maximum number of consecutive position setpoints that the interpolation extrapolates; ours.
constexpr std::uint32_t kBridgedSetpoints = 8;

}  // namespace

DriveMotion::DriveMotion(const MotorParameters& motor, double initial_position_rad) noexcept
    : motor_(motor, kControlStepS, initial_position_rad),
      controller_({}, kControlStepS),
      frequency_control_(kControlStepS) {
  controller_.reset(measured_position_rad(), 0.0);
  slow_steps_ = kStandstillSteps;
  motor_.set_power_stage(false);
}

void DriveMotion::configure(const MotionSettings& settings) noexcept {
  const double before = ramp_rad_s2();
  settings_ = settings;
  if (ramping_ && (ramp_rad_s2() < before || ramp_rad_s2() > before)) run_ramp();
  controller_.configure(settings.controller);
  frequency_control_.configure(settings.voltage_frequency);
  position_.configure(settings.method, settings.steps_per_setpoint, kControlStepS);
  position_.set_limits(kBridgedSetpoints, settings.quick_stop_rad_s2, settings.controller.max_velocity_rad_s);
  // Speed and torque setpoints are always interpolated linearly (Device Help 8).
  const auto method = settings.method == FineInterpolator::Method::kNone ? FineInterpolator::Method::kNone
                                                                         : FineInterpolator::Method::kLinear;
  velocity_.configure(method, settings.steps_per_setpoint, kControlStepS);
  torque_.configure(method, settings.steps_per_setpoint, kControlStepS);
  // Missing setpoints are held: with linear extrapolation a speed would exceed its limits (ours).
  velocity_.set_limits(0, 0.0);
  torque_.set_limits(0, 0.0);
}

void DriveMotion::set(const Setpoints& setpoints) noexcept {
  setpoints_ = setpoints;
  if (command_ == MotionCommand::kFollow) return push_setpoints();
  // Records the age of the setpoint, for a drive that is switched on later.
  steps_since_sample_ = 0;
}

void DriveMotion::push_setpoints() noexcept {
  const std::uint32_t expected = settings_.steps_per_setpoint;
  const bool on_time = steps_since_sample_ + 1 - expected <= 2;  // at most one step early or late
  samples_on_time_ = on_time ? std::min(samples_on_time_ + 1, kSamplesForSynchronism) : 0;
  steps_since_sample_ = 0;
  // Only the active source starts a segment: the others take over the current setpoint when they are selected.
  if (source_ == MotionSource::kCyclicVelocity) velocity_.push(setpoints_.velocity_rad_s);
  if (source_ == MotionSource::kCyclicTorque) torque_.push(setpoints_.torque_nm);
  if (source_ != MotionSource::kCyclicPosition) return;
  // Position setpoints wrap around at the ends of their range; the shorter distance applies.
  target_position_ = settings_.range.nearest(target_position_, setpoints_.position);
  std::int64_t target = target_position_;
  limited_ = false;
  if (settings_.position_limited) {
    const std::int64_t low = settings_.position_min;
    const std::int64_t high = settings_.position_max;
    limited_ = target < low || target > high;
    // An axis beyond a limit stays at standstill until its target leads back: the limit alone causes no movement.
    target = std::clamp(target, std::min(low, allowed_position_), std::max(high, allowed_position_));
  }
  allowed_position_ = target;
  const double fraction = target == target_position_ ? setpoints_.position_fraction : 0.0;
  position_.push(to_rad(static_cast<double>(target) + fraction), setpoints_.velocity_offset_rad_s);
}

void DriveMotion::move_to(std::int64_t position, const GeneratorLimits& limits) noexcept {
  generator_.move_to(to_rad(static_cast<double>(position)), limits);
}

void DriveMotion::run_at(double velocity_rad_s, const GeneratorLimits& limits) noexcept {
  generator_.run_at(velocity_rad_s, limits);
}

void DriveMotion::stand() noexcept {
  generator_.run_at(0.0, {1.0, settings_.slow_down_rad_s2, settings_.slow_down_rad_s2, settings_.jerk_time_s});
}

/// Returns the deceleration of the active braking ramp.
double DriveMotion::ramp_rad_s2() const noexcept {
  return command_ == MotionCommand::kSlowDownRamp ? settings_.slow_down_rad_s2 : settings_.quick_stop_rad_s2;
}

void DriveMotion::run_ramp() noexcept {
  generator_.run_at(0.0, {1.0, ramp_rad_s2(), ramp_rad_s2(), ramp_jerk_time_s_});
}

void DriveMotion::freeze() noexcept {
  generator_.reset({generator_.state().position, generator_.state().velocity, 0.0});
}

void DriveMotion::set_zero(std::int64_t increments) noexcept {
  zero_ = increments;
  target_position_ = allowed_position_ = position();
}

void DriveMotion::restart_encoder() noexcept {
  if (motor_.parameters().encoder_turns != MotorParameters::kAllTurns) set_zero(motor_.power_on_origin());
}

/// Returns the start of the next movement: the measured position with the present speed setpoint and the acceleration
/// of the demand, so that the next ramp continues them. If the axis cannot follow, returns its measured speed.
ProfileState DriveMotion::motion_in_force() const noexcept {
  const ProfileState measured{measured_position_rad(), controller_.measured_velocity_rad_s(), 0.0};
  const bool ramp = command_ == MotionCommand::kSlowDownRamp || command_ == MotionCommand::kQuickStopRamp;
  if (by_frequency_ || controller_.limited() || (command_ != MotionCommand::kFollow && !ramp)) return measured;
  const auto with = [&](double acceleration) {
    return ProfileState{measured.position, controller_.velocity_setpoint_rad_s(), acceleration};
  };
  if (ramp || source_ == MotionSource::kProfilePosition || source_ == MotionSource::kProfileVelocity) {
    return with(generator_.state().acceleration);
  }
  if (source_ == MotionSource::kCyclicPosition) return with(position_.acceleration());
  return source_ == MotionSource::kCyclicVelocity ? with(velocity_.velocity()) : measured;
}

void DriveMotion::take_over(MotionCommand command, MotionSource source, bool smooth) noexcept {
  const bool ramp = command == MotionCommand::kSlowDownRamp || command == MotionCommand::kQuickStopRamp;
  const bool by_frequency =
      (command == MotionCommand::kFollow && source == MotionSource::kProfileFrequency) || (ramp && by_frequency_);
  // In U/f operation the frequency is the only known speed.
  const bool same_frequency = by_frequency && by_frequency_;
  const double speed = same_frequency ? generator_.state().velocity : controller_.measured_velocity_rad_s();
  auto before = motion_in_force();
  if (by_frequency) before = {before.position, speed, same_frequency ? generator_.state().acceleration : 0.0};
  if (by_frequency != by_frequency_) {
    by_frequency_ = by_frequency;
    motor_.drive_by_voltage(by_frequency);
    if (by_frequency) start_frequency_control();
  }
  command_ = command;
  motor_.set_power_stage(command != MotionCommand::kOff);
  source_ = source;
  limited_ = false;
  samples_on_time_ = 0;
  generator_.reset(before);
  if (command == MotionCommand::kTorqueLimit) start_limit_stop();
  ramp_jerk_time_s_ = smooth ? settings_.jerk_time_s : 0.0;
  ramping_ = ramp;
  if (ramping_) run_ramp();
  if (command != MotionCommand::kFollow) return;
  if (source == MotionSource::kProfilePosition) stand();  // until a movement is commanded
  if (source == MotionSource::kProfileFrequency) generator_.run_at(speed, {1.0, 1.0, 1.0, 0.0});
  target_position_ = allowed_position_ = position();
  // The current setpoint takes effect at once (Device Help 8), as if it had done so on arrival: the next setpoint
  // arrives earlier than a period from now by that age. The targets do not include the offsets.
  const std::uint32_t since = steps_since_sample_ % settings_.steps_per_setpoint;
  const double begin_speed = source == MotionSource::kCyclicPosition ? speed_towards_setpoint(speed, since) : speed;
  position_.reset(measured_position_rad() - begin_speed * since * kControlStepS, begin_speed);
  velocity_.reset(setpoints_.velocity_rad_s, 0.0);
  torque_.reset(torque_demand_nm_ - setpoints_.torque_offset_nm, 0.0);
  push_setpoints();
  for (std::uint32_t step = 0; step < since; ++step) {
    position_.step();
    velocity_.step();
    torque_.step();
  }
  steps_since_sample_ = since;
}

/// The measured speed lags by its filter. If the position setpoint implies nearly the same speed, that is used.
double DriveMotion::speed_towards_setpoint(double speed, std::uint32_t since) const noexcept {
  const auto target = settings_.range.nearest(position(), setpoints_.position);
  const double steps = position_.periods_ahead() * settings_.steps_per_setpoint - since;
  if (!(steps > 0.0)) return speed;
  const double asked = (to_rad(static_cast<double>(target) + setpoints_.position_fraction) - measured_position_rad()) /
                       (steps * kControlStepS);
  return std::abs(asked - speed) <= settings_.quick_stop_rad_s2 * kSpeedLagS ? asked : speed;
}

double DriveMotion::speed_feed_forward(double internal_rad_s) const noexcept {
  const double speed = settings_.external_speed_feed_forward ? setpoints_.velocity_offset_rad_s : internal_rad_s;
  return settings_.speed_feed_forward * speed;
}

double DriveMotion::torque_feed_forward(double acceleration_rad_s2) const noexcept {
  return settings_.external_torque_feed_forward ? settings_.torque_feed_forward * setpoints_.torque_offset_nm
                                                : internal_torque(acceleration_rad_s2);
}

double DriveMotion::internal_torque(double acceleration_rad_s2) const noexcept {
  return settings_.torque_feed_forward * settings_.feed_forward_inertia_kg_m2 * acceleration_rad_s2;
}

/// The measured position is that at the start of the step, and so is the position that it is compared with.
double DriveMotion::follow_position() noexcept {
  const double reference_rad = position_.value();
  position_.step();
  return controller_.step({Loop::kPosition, reference_rad, speed_feed_forward(position_.velocity()),
                           torque_feed_forward(position_.acceleration())});
}

/// In velocity mode there is no internal feed-forward: the offsets act only if they are selected as external sources.
double DriveMotion::follow_velocity() noexcept {
  velocity_.step();
  return controller_.step(
      {Loop::kVelocity, 0.0, velocity_.value() + speed_feed_forward(0.0), torque_feed_forward(0.0)});
}

/// Limits the torque so that the axis approaches the maximum speed (6080h) smoothly and is not driven beyond it.
double DriveMotion::follow_torque() noexcept {
  torque_.step();
  double torque = torque_.value() + setpoints_.torque_offset_nm;
  const double speed = controller_.measured_velocity_rad_s();
  const double left = std::max(settings_.controller.max_velocity_rad_s - std::abs(speed), 0.0);
  const double most = inertia() * left / kSpeedLimitS;
  limited_ = torque * speed > 0.0 && std::abs(torque) > most;
  if (limited_) torque = std::copysign(most, torque);
  return controller_.step({Loop::kTorque, 0.0, 0.0, torque});
}

/// The profile generator feeds forward its own speed and acceleration (Device Help 8: it gives the pre-control).
double DriveMotion::follow_profile_position() noexcept {
  const double reference_rad = generator_.state().position;
  generator_.step(kControlStepS);
  const ProfileState& state = generator_.state();
  return controller_.step({Loop::kPosition, reference_rad, settings_.speed_feed_forward * state.velocity,
                           internal_torque(state.acceleration)});
}

double DriveMotion::follow_profile_velocity() noexcept {
  generator_.step(kControlStepS);
  const ProfileState& state = generator_.state();
  return controller_.step({Loop::kVelocity, 0.0, state.velocity, internal_torque(state.acceleration)});
}

double DriveMotion::inertia() const noexcept {
  return settings_.feed_forward_inertia_kg_m2 > 0.0 ? settings_.feed_forward_inertia_kg_m2
                                                    : motor_.parameters().inertia_kg_m2;
}

/// The speed loop continues with the present torque.
void DriveMotion::start_limit_stop() noexcept {
  stop_velocity_rad_s_ = controller_.measured_velocity_rad_s();
  torque_demand_nm_ = controller_.step({Loop::kVelocity, 0.0, stop_velocity_rad_s_, 0.0});
}

/// Brakes with the maximum torque, then with so much less that the axis comes to rest without reversing: the speed
/// setpoint follows the axis while the torque is at its limit, then decays to zero with a time constant (ours).
double DriveMotion::stop_at_limit() noexcept {
  const double most = settings_.controller.max_torque_nm / inertia();
  const double time_s = std::max(kStopShare * settings_.controller.velocity_reset_s, kStopAtLeastS);
  if (controller_.limited()) stop_velocity_rad_s_ = controller_.measured_velocity_rad_s();
  const double deceleration = std::clamp(stop_velocity_rad_s_ / time_s, -most, most);
  stop_velocity_rad_s_ -= deceleration * kControlStepS;
  return controller_.step({Loop::kVelocity, 0.0, stop_velocity_rad_s_, -inertia() * deceleration});
}

double DriveMotion::follow() noexcept {
  switch (source_) {
    case MotionSource::kCyclicPosition:
      return follow_position();
    case MotionSource::kCyclicVelocity:
      return follow_velocity();
    case MotionSource::kCyclicTorque:
      return follow_torque();
    case MotionSource::kProfilePosition:
      return follow_profile_position();
    case MotionSource::kProfileVelocity:
      return follow_profile_velocity();
    case MotionSource::kProfileFrequency:
    case MotionSource::kNone:
      break;
  }
  return controller_.step({Loop::kVelocity, 0.0, 0.0, 0.0});
}

/// Returns the torque demand of the command in force.
double DriveMotion::obey() noexcept {
  switch (command_) {
    case MotionCommand::kOff:
      break;
    case MotionCommand::kFollow:
      return follow();
    case MotionCommand::kSlowDownRamp:
    case MotionCommand::kQuickStopRamp:
      return follow_profile_velocity();
    case MotionCommand::kTorqueLimit:
      return stop_at_limit();
  }
  return controller_.step({});
}

void DriveMotion::select(MotionCommand command, MotionSource source, bool smooth) noexcept {
  if (command != command_ || source != source_) take_over(command, source, smooth);
}

void DriveMotion::step(bool brake_closed) noexcept {
  controller_.measure(measured_position_rad());
  slow_steps_ = slow() ? std::min(slow_steps_ + 1, kStandstillSteps) : 0;
  steps_since_sample_ += steps_since_sample_ < 2 * settings_.steps_per_setpoint ? 1 : 0;
  if (by_frequency_) return step_frequency_control(brake_closed);
  const TorqueRange range = motor_.torque_range();
  const double demand = settings_.torque_per_demand;
  controller_.set_available_torque(range.lowest_nm / demand, range.highest_nm / demand);
  // Cyclic positions come first: most drives follow them.
  const bool cyclic = command_ == MotionCommand::kFollow && source_ == MotionSource::kCyclicPosition;
  torque_demand_nm_ = cyclic ? follow_position() : obey();
  motor_.step(torque_demand_nm_ * demand, range, brake_closed);
}

double DriveMotion::following_error() const noexcept {
  return position_demand() - static_cast<double>(position());
}

double DriveMotion::following_error_increments() const noexcept {
  if (!position_controlled()) return 0.0;
  return (position_setpoint_rad() - measured_position_rad()) / motor_.radians_per_increment();
}

double DriveMotion::velocity() const noexcept {
  return controller_.measured_velocity_rad_s() / settings_.scaling.velocity_rad_s;
}

double DriveMotion::velocity_demand() const noexcept {
  if (command_ == MotionCommand::kOff) return 0.0;
  const double demand = by_frequency_ ? generator_.state().velocity : controller_.velocity_setpoint_rad_s();
  return demand / settings_.scaling.velocity_rad_s;
}

/// Through short-circuited cables the full DC link voltage drives the current, in every pulse of the inverter.
double DriveMotion::phase_current_a(double dc_link_volts) const noexcept {
  constexpr double kCableOhm = 0.5;
  if (motor_.short_circuit()) return command_ == MotionCommand::kOff ? 0.0 : dc_link_volts / kCableOhm;
  return motor_.current_a();
}

bool DriveMotion::slow() const noexcept {
  return std::abs(controller_.measured_velocity_rad_s()) < settings_.standstill_rad_s;
}

int DriveMotion::direction() const noexcept {
  constexpr double kStanding = 1e-3;  // rad/s
  double speed = 0.0;
  switch (source_) {
    case MotionSource::kNone:
      break;
    case MotionSource::kCyclicPosition:
      speed = position_.velocity();
      break;
    case MotionSource::kCyclicVelocity:
      speed = velocity_.value();
      break;
    case MotionSource::kCyclicTorque:
      speed = slow() ? 0.0 : controller_.measured_velocity_rad_s();
      break;
    case MotionSource::kProfilePosition:
    case MotionSource::kProfileVelocity:
    case MotionSource::kProfileFrequency:
      speed = generator_.state().velocity;
      break;
  }
  if (settings_.scaling.inverted) speed = -speed;
  return speed > kStanding ? 1 : speed < -kStanding ? -1 : 0;
}

double DriveMotion::distance_to_speed() const noexcept {
  if (source_ != MotionSource::kCyclicVelocity) return 0.0;
  return setpoints_.velocity_rad_s / settings_.scaling.velocity_rad_s - velocity();
}

}  // namespace driveline::slaves::msd
