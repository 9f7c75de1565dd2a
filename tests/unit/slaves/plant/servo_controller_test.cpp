#include "driveline/slaves/plant/servo_controller.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves {
namespace {

using Loop = ControllerSetpoint::Loop;
constexpr double kStep = 62.5e-6;

/// Motor and controller closed over the encoder.
struct Axis {
  ServoMotor motor = ServoMotor(MotorParameters{}, kStep, 0.0);
  ServoController controller = ServoController(ControllerParameters{}, kStep);

  double step(const ControllerSetpoint& setpoint) {
    controller.measure(static_cast<double>(motor.encoder_count()) * motor.radians_per_increment());
    const double torque = controller.step(setpoint);
    motor.step(torque);
    return torque;
  }
};

TEST(ServoController, VelocityStepSettlesWithoutError) {
  Axis axis;
  double peak = 0.0;
  for (int i = 0; i < 1600; ++i) {
    axis.step({Loop::kVelocity, 0.0, 100.0, 0.0});
    peak = std::max(peak, axis.motor.velocity_rad_s());
  }
  EXPECT_NEAR(axis.motor.velocity_rad_s(), 100.0, 0.05);
  EXPECT_LT(peak, 150.0);
}

TEST(ServoController, PositionLoopHoldsAgainstFriction) {
  Axis axis;
  for (int i = 0; i < 8000; ++i) axis.step({Loop::kPosition, 0.5, 0.0, 0.0});
  EXPECT_NEAR(axis.motor.position_rad(), 0.5, 1e-4);
  EXPECT_NEAR(axis.motor.velocity_rad_s(), 0.0, 0.05);
}

TEST(ServoController, FeedForwardLeavesLittleFollowingError) {
  const auto worst = [](double share) {
    Axis axis;
    double error = 0.0;
    for (int i = 0; i < 32000; ++i) {
      const double t = i * kStep;
      const double w = 2.0 * 3.14159265358979 * 2.0;
      const double position = 1.0 - std::cos(w * t);
      axis.step({Loop::kPosition, position, share * w * std::sin(w * t), share * 3e-4 * w * w * std::cos(w * t)});
      if (t > 0.5) error = std::max(error, std::abs(position - axis.motor.position_rad()));
    }
    return error;
  };
  const double without = worst(0.0);
  const double with = worst(1.0);
  EXPECT_NEAR(without, 12.57 / 150.0, 0.02);  // speed over position gain
  EXPECT_LT(with, without / 20.0);
}

TEST(ServoController, TorqueIsLimitedAndTheIntegratorDoesNotWindUp) {
  Axis axis;
  double peak = 0.0;
  bool limited = false;
  for (int i = 0; i < 3200; ++i) {  // 400 rad/s take 17 ms with the peak torque
    EXPECT_LE(std::abs(axis.step({Loop::kVelocity, 0.0, 400.0, 0.0})), 7.2);
    limited = limited || axis.controller.limited();
    peak = std::max(peak, axis.motor.velocity_rad_s());
  }
  EXPECT_TRUE(limited);
  EXPECT_LT(peak, 410.0);
  EXPECT_NEAR(axis.motor.velocity_rad_s(), 400.0, 0.5);
}

TEST(ServoController, TorqueLimitOfTheSetpointIsKept) {
  ServoController controller({.max_torque_nm = 1.0}, kStep);
  EXPECT_DOUBLE_EQ(controller.step({Loop::kTorque, 0.0, 0.0, 5.0}), 1.0);
  EXPECT_TRUE(controller.limited());
  EXPECT_DOUBLE_EQ(controller.step({Loop::kTorque, 0.0, 0.0, -0.5}), -0.5);
  EXPECT_FALSE(controller.limited());
}

TEST(ServoController, LoopsAreChangedWithoutATorqueStep) {
  Axis axis;
  double torque = 0.0;
  for (int i = 0; i < 1600; ++i) torque = axis.step({Loop::kTorque, 0.0, 0.0, 0.2});
  const double speed = axis.controller.measured_velocity_rad_s();
  double next = axis.step({Loop::kVelocity, 0.0, speed, 0.0});
  EXPECT_NEAR(next, torque, 0.05);
  for (int i = 0; i < 1600; ++i) torque = axis.step({Loop::kVelocity, 0.0, speed, 0.0});
  next = axis.step({Loop::kPosition, axis.motor.position_rad(), speed, 0.0});
  EXPECT_NEAR(next, torque, 0.05);
}

TEST(ServoController, NothingNotFiniteGetsThrough) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ControllerParameters broken{nan, nan, nan, nan, nan, nan};
  ServoController controller(broken, kStep);
  controller.configure({.position_gain_per_s = nan, .velocity_gain_nm_s = -1.0});
  controller.reset(nan, nan);
  constexpr std::array kLoops = {Loop::kPosition, Loop::kVelocity, Loop::kTorque};
  for (const auto loop : kLoops) {
    controller.measure(nan);
    EXPECT_TRUE(std::isfinite(controller.step({loop, nan, nan, nan})));
    EXPECT_TRUE(std::isfinite(controller.step({loop, 1e308, 1e308, 1e308})));
  }
}

}  // namespace
}  // namespace driveline::slaves
