#include "driveline/slaves/msd/motion.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/msd/device_layout.hpp"

namespace driveline::slaves::msd {

using Loop = ControllerSetpoint::Loop;

Motion::Motion(const MotorParameters& motor, double initial_position_rad) noexcept
    : motor_(motor, kControlStepS, initial_position_rad), controller_({}, kControlStepS) {
  controller_.reset(measured_position_rad(), 0.0);
}

void Motion::configure(const MotionSettings& settings) noexcept {
  settings_ = settings;
  units_per_increment_ = motor_.radians_per_increment() / settings.scaling.position_rad;
  controller_.configure(settings.controller);
  position_.configure(settings.method, settings.steps_per_setpoint, kControlStepS);
  // Speed and torque setpoints are always interpolated linearly (Device Help 8).
  const auto method = settings.method == FineInterpolator::Method::kNone ? FineInterpolator::Method::kNone
                                                                         : FineInterpolator::Method::kLinear;
  velocity_.configure(method, settings.steps_per_setpoint, kControlStepS);
  torque_.configure(method, settings.steps_per_setpoint, kControlStepS);
}

double Motion::measured_position_rad() const noexcept {
  return static_cast<double>(motor_.encoder_count()) * motor_.radians_per_increment();
}

std::int64_t Motion::position() const noexcept {
  return std::llrint(static_cast<double>(motor_.encoder_count()) * units_per_increment_);
}

double Motion::torque_of(double permille) const noexcept {
  return permille * 1e-3 * motor_.parameters().rated_torque_nm;
}

void Motion::set(const Setpoints& setpoints) noexcept {
  setpoints_ = setpoints;
  if (command_ == MotionCommand::kFollow) push_setpoints();
}

void Motion::push_setpoints() noexcept {
  // Position setpoints wrap at 32 bits; the shorter way is meant.
  const auto difference = static_cast<std::int32_t>(static_cast<std::uint32_t>(setpoints_.position) -
                                                    static_cast<std::uint32_t>(target_position_));
  target_position_ += difference;
  std::int64_t target = target_position_;
  limited_ = false;
  if (settings_.position_limited) {
    target = std::clamp<std::int64_t>(target, settings_.position_min, settings_.position_max);
    limited_ = target != target_position_;
  }
  position_.push(static_cast<double>(target) * settings_.scaling.position_rad);
  velocity_.push(setpoints_.velocity * settings_.scaling.velocity_rad_s);
  torque_.push(torque_of(setpoints_.torque_permille));
}

void Motion::take_over(MotionCommand command, OperationMode mode) noexcept {
  const double speed = controller_.measured_velocity_rad_s();
  command_ = command;
  mode_ = mode;
  limited_ = false;
  ramp_rad_s_ = 0.0;
  if (command == MotionCommand::kSlowDownRamp || command == MotionCommand::kQuickStopRamp) ramp_rad_s_ = speed;
  if (command != MotionCommand::kFollow) return;
  target_position_ = position();
  position_.reset(measured_position_rad(), speed);
  velocity_.reset(speed, 0.0);
  torque_.reset(torque_demand_nm_, 0.0);
  push_setpoints();  // the present setpoint acts at once (Device Help 8)
}

double Motion::speed_feed_forward(double internal_rad_s) const noexcept {
  const double speed = settings_.external_speed_feed_forward
                           ? setpoints_.velocity_offset * settings_.scaling.velocity_rad_s
                           : internal_rad_s;
  return settings_.speed_feed_forward * speed;
}

double Motion::torque_feed_forward(double acceleration_rad_s2) const noexcept {
  const double torque = settings_.external_torque_feed_forward
                            ? torque_of(setpoints_.torque_offset_permille)
                            : settings_.feed_forward_inertia_kg_m2 * acceleration_rad_s2;
  return settings_.torque_feed_forward * torque;
}

/// The measured position is that of the beginning of the step, and so is the position it is compared with.
double Motion::follow_position() noexcept {
  const double reference_rad = position_.value();
  position_.step();
  return controller_.step({Loop::kPosition, reference_rad, speed_feed_forward(position_.velocity()),
                           torque_feed_forward(position_.acceleration())});
}

/// In velocity mode there is no internal feed-forward: the offsets act when they are selected as external sources.
double Motion::follow_velocity() noexcept {
  velocity_.step();
  return controller_.step(
      {Loop::kVelocity, 0.0, velocity_.value() + speed_feed_forward(0.0), torque_feed_forward(0.0)});
}

double Motion::follow_torque() noexcept {
  torque_.step();
  double torque = torque_.value() + torque_of(setpoints_.torque_offset_permille);
  const double speed = controller_.measured_velocity_rad_s();
  limited_ = std::abs(speed) > settings_.controller.max_velocity_rad_s && (torque > 0.0) == (speed > 0.0);
  if (limited_) torque = 0.0;
  return controller_.step({Loop::kTorque, 0.0, 0.0, torque});
}

double Motion::follow() noexcept {
  switch (mode_) {
    case OperationMode::kCyclicSynchronousPosition:
      return follow_position();
    case OperationMode::kCyclicSynchronousVelocity:
      return follow_velocity();
    case OperationMode::kCyclicSynchronousTorque:
      return follow_torque();
    case OperationMode::kNone:
      break;
  }
  return controller_.step({Loop::kVelocity, 0.0, 0.0, 0.0});
}

double Motion::brake(double deceleration_rad_s2) noexcept {
  const double change = deceleration_rad_s2 * kControlStepS;
  const bool ends = std::abs(ramp_rad_s_) <= change;
  const double braking = ends ? 0.0 : -std::copysign(deceleration_rad_s2, ramp_rad_s_);
  ramp_rad_s_ = ends ? 0.0 : ramp_rad_s_ + braking * kControlStepS;
  return controller_.step({Loop::kVelocity, 0.0, ramp_rad_s_, settings_.feed_forward_inertia_kg_m2 * braking});
}

void Motion::step(MotionCommand command, OperationMode mode) noexcept {
  controller_.measure(measured_position_rad());
  if (command != command_ || mode != mode_) take_over(command, mode);
  switch (command) {
    case MotionCommand::kOff:
      torque_demand_nm_ = controller_.step({});
      break;
    case MotionCommand::kFollow:
      torque_demand_nm_ = follow();
      break;
    case MotionCommand::kSlowDownRamp:
      torque_demand_nm_ = brake(settings_.slow_down_rad_s2);
      break;
    case MotionCommand::kQuickStopRamp:
      torque_demand_nm_ = brake(settings_.quick_stop_rad_s2);
      break;
    case MotionCommand::kTorqueLimit:
      torque_demand_nm_ = controller_.step({Loop::kVelocity, 0.0, 0.0, 0.0});
      break;
  }
  motor_.step(torque_demand_nm_);
}

double Motion::position_demand() const noexcept {
  const bool positioning = command_ == MotionCommand::kFollow && mode_ == OperationMode::kCyclicSynchronousPosition;
  return positioning ? position_.value() / settings_.scaling.position_rad : static_cast<double>(position());
}

double Motion::following_error() const noexcept {
  return position_demand() - static_cast<double>(position());
}

double Motion::velocity() const noexcept {
  return controller_.measured_velocity_rad_s() / settings_.scaling.velocity_rad_s;
}

double Motion::velocity_demand() const noexcept {
  return command_ == MotionCommand::kOff ? 0.0
                                         : controller_.velocity_setpoint_rad_s() / settings_.scaling.velocity_rad_s;
}

double Motion::torque_permille() const noexcept {
  return 1000.0 * motor_.torque_nm() / motor_.parameters().rated_torque_nm;
}

double Motion::torque_demand_permille() const noexcept {
  return 1000.0 * torque_demand_nm_ / motor_.parameters().rated_torque_nm;
}

bool Motion::standstill() const noexcept {
  return std::abs(controller_.measured_velocity_rad_s()) < settings_.standstill_rad_s;
}

double Motion::distance_to_target() const noexcept {
  switch (mode_) {
    case OperationMode::kCyclicSynchronousPosition:
      return static_cast<double>(target_position_ - position());
    case OperationMode::kCyclicSynchronousVelocity:
      return setpoints_.velocity - velocity();
    default:
      return 0.0;
  }
}

}  // namespace driveline::slaves::msd
